"""The campaign of the blind proof: what is done is kept, and what is left is done next time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from deltactl.proof.prove.resumable import Means
from deltactl.repair import campaign
from deltactl.repair.campaign import prove_repair


def test_it_stops_after_its_minutes_and_goes_on_from_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run_case(seed: int, number: int, folder: Path, networks: bool) -> dict[str, Any]:
        sizes = {"before_m": 1e-3, "after_m": 1e-4, "possible_m": 8e-5}
        return {"number": number, "concealed": ["home_offset on motor1"], **sizes}

    monkeypatch.setattr(campaign, "run_case", run_case)
    said: list[str] = []

    def prove(minutes: float) -> list[int]:
        rows = prove_repair(3, 1, tmp_path, False, Means(0, minutes=minutes, say=said.append))
        return [row.number for row in rows]

    assert prove(0.0) == [0]
    assert "the same command again goes on" in said[0]
    assert prove(10.0) == [0, 1, 2]
    assert len(said) == 1
