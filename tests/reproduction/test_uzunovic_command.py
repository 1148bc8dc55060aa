"""`deltactl network reproduce uzunovic-2013 --quick`: both sections, shortened."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("mujoco", reason="the micro delta needs the extra 'proof'")
pytest.importorskip("tflite", reason="training needs the extra 'training'")

from deltactl.reproduction.uzunovic_2013 import control

SHORT_S = 2.2
"""Control is on from 1 s and judged from 2 s; a whole experiment takes 11 s."""


@pytest.mark.study
def test_both_sections_are_printed_and_drawn(
    here, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(control, "WHOLE_S", SHORT_S)
    monkeypatch.setattr(control, "EXPERIMENTS", control.EXPERIMENTS[:1])
    out = tmp_path / "uzunovic"
    done = here("network", "reproduce", "uzunovic-2013", "--quick", "--out", out)
    assert done.returncode == 0, done.stderr
    for words in ("Section 3.1", "Table 1", "0.8270", "Tracking error", "disturbance observer"):
        assert words in done.stdout
    page = (out / "report.html").read_text(encoding="utf-8")
    for figure in (3, 4, 5, 7, 8):
        assert f"Figure {figure}" in page
    # The bound of the paper lies above and below, and is one curve of one name.
    assert page.count("the paper's 1.1 %") == 2  # one each for the law and the slow observers
    assert "| alpha_1s |" in (out / "tables.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("paper", ["uzunovic-2013", "zhao-2023"])
def test_a_folder_that_cannot_be_written_is_said_before_any_work(
    here, tmp_path: Path, paper: str
) -> None:
    (tmp_path / "file").write_text("")
    done = here("network", "reproduce", paper, "--quick", "--out", tmp_path / "file" / "out")
    assert done.returncode == 2
    (line,) = done.stderr.strip().splitlines()
    assert "cannot be written" in line
