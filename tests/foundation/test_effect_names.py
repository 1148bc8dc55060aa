"""Nothing outside models/effects names an effect, but for what is listed here and may only shrink.

Counted are string literals that are the name of a registered effect, alone or before a dot. Where
one effect is meant (a calibration is written as effects), its operator is imported.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from benchmarks.size import outside_the_cards, program
from benchmarks.structure import ROOT
from deltactl.models.effects import CARDS

EXPERIMENT = {"benchmarks/proofs/compensated.py": 4, "benchmarks/proofs/detection_limit.py": 8}
"""What an experiment hides, by the contract's names, as `proof` does."""
HOMONYMS = {
    "benchmarks/proofs/recording_variations.py": 2,
    "deltactl/diagnosis/plants/lone/force_shapes.py": 2,
    "deltactl/diagnosis/plants/lone/forced_axis.py": 3,
    "models/rigid_chain.py": 1,
    "models/robot.py": 2,
    "deltactl/reference/words.py": 2,
    "firmware_py/exporting/urdf.py": 1,
    "deltactl/repair/corrected_model.py": 1,
    "firmware_py/robot_file.py": 1,
    "firmware_py/describing/questions.py": 3,
}
"""Keys of robot files, questions of `deltactl init`, a tag of URDF, and a parameter that have an
effect's name."""
ALLOWED = EXPERIMENT | HOMONYMS


def wrong(found: Mapping[str, int], allowed: Mapping[str, int]) -> list[str]:
    """A line for each file that names more effects than it may, or fewer than it is listed with."""
    lines = []
    for file in sorted({*found, *allowed}):
        is_, may = found.get(file, 0), allowed.get(file, 0)
        if is_ > may:
            lines.append(f"{file}: {is_} names of effects, {may} are allowed: ask the card instead")
        if is_ < may:
            lines.append(f"{file}: {is_} names of effects: set its entry of ALLOWED from {may}")
    return lines


def test_effects_are_named_in_their_own_files_only() -> None:
    assert wrong(outside_the_cards(program(ROOT), CARDS), ALLOWED) == []


@pytest.mark.parametrize(("allowed", "says"), [(0, "ask the card"), (2, "set its entry")])
def test_a_name_more_and_a_name_less_are_seen(tmp_path: Path, allowed: int, says: str) -> None:
    for folder in ("deltactl", "drivers", "models"):
        (tmp_path / folder).mkdir()
    (tmp_path / "drivers" / "a.py").write_text('ODDS = {"home_offset": 0.1, "other": 0.2}\n')
    (tmp_path / "models" / "effects").mkdir()
    (tmp_path / "models" / "effects" / "b.py").write_text('NAME = "home_offset"\n')
    (tmp_path / "deltactl" / "models").symlink_to(tmp_path / "models")
    found = outside_the_cards(program(tmp_path), CARDS)
    (line,) = wrong(found, {"drivers/a.py": allowed} if allowed else {})
    assert line.startswith("drivers/a.py: 1 ")
    assert says in line
