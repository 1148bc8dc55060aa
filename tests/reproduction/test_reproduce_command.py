"""`deltactl network reproduce zhao-2023 --quick`: all stages once, then from what is kept."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the as-built robot needs the extra 'proof'")
pytest.importorskip("tflite", reason="training needs the extra 'training'")
pytest.importorskip("numba", reason="training needs the extra 'training'")

from deltactl.firmware_py.named_files import find
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot_files import load_delta
from deltactl.models.training.dataset import load_dataset
from deltactl.models.training.sources import of_dataset
from deltactl.models.training.train import train_from_samples
from deltactl.reproduction.outcome import Sheet, kept
from deltactl.reproduction.zhao_2023.run import recipes
from deltactl.reproduction.zhao_2023.study import FULL


def made_at(out: Path) -> dict[str, int]:
    """When each track and network under a folder was written [ns]: what takes long to work out."""
    files = (path for path in out.rglob("*") if path.suffix in {".npz", ".tflite"})
    return {str(path.relative_to(out)): path.stat().st_mtime_ns for path in files}


@pytest.mark.study
def test_everything_short_and_again_from_what_is_kept(here, tmp_path: Path) -> None:
    out = tmp_path / "zhao"
    first = here("network", "reproduce", "zhao-2023", "--quick", "--out", out)
    assert first.returncode == 0, first.stderr
    for words in ("Table 3", "Table 4", "Figures 10 to 15", "limit", "0.1015", "46.5250"):
        assert words in first.stdout
    page = (out / "report.html").read_text(encoding="utf-8")
    for figure in (4, 5, *range(7, 16)):
        assert f"Figure {figure}:" in page
    assert "<script src" not in page  # the charts' library stands in the page
    markup = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert "http" not in markup.replace("http://www.w3.org", "").replace("http-equiv", "")
    made = made_at(out)
    track, network = out / "tracks" / "limit-heart-0.006.npz", out / "networks-10/zhao-100.tflite"
    track.write_bytes(b"half a file")
    # A network kept from a program with another recipe is not gone on with.
    source = of_dataset(load_dataset(out / "data").first(100), load_delta(find("zhao-2023.yaml")))
    train_from_samples(source, "zhao", network, 0, 9)
    again = here("network", "reproduce", "zhao-2023", "--quick", "--out", out)
    assert again.stdout == first.stdout
    assert "limit" in again.stderr
    assert again.stderr.count("training ") == again.stderr.count("training zhao-100") > 0
    now = made_at(out)
    assert now.keys() == made.keys()
    worked_out = {name for name in made if now[name] != made[name]}
    assert worked_out == {str(one.relative_to(out)) for one in (track, network)}


def test_the_tables_of_the_docs_are_of_the_recipes_there_are() -> None:
    """The tables once were of a learning rate that had been changed since."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "reproduction.md").read_text()
    assert recipes(FULL.effort) in page


@pytest.mark.study
def test_a_full_disk_is_one_line(cli, tmp_path: Path) -> None:
    done = cli(
        "network", "reproduce", "zhao-2023", "--quick", "--out", tmp_path / "zhao", disk=4000
    )
    assert done.returncode == 2
    assert "cannot be written" in done.stderr.strip().splitlines()[-1]
    assert "Traceback" not in done.stderr


def test_a_result_is_made_again_when_its_causes_change(tmp_path: Path) -> None:
    calls = []

    def make() -> dict[str, np.ndarray]:
        calls.append(1)
        return {"numbers": np.arange(3.0)}

    path = tmp_path / "stage.npz"
    for mark, made in (("a", 1), ("a", 1), ("b", 2)):
        assert np.array_equal(kept(path, mark, make)["numbers"], [0.0, 1.0, 2.0])
        assert len(calls) == made
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        kept(tmp_path / "file" / "stage.npz", "a", make)


def test_a_sheet_in_three_forms() -> None:
    sheet = Sheet("Sizes", ["name", "mm"], [["long", "1.25"], ["a", "10.5"]], note="By hand.")
    assert sheet.text().splitlines()[2:] == ["name    mm", "──────────", "long  1.25", "a     10.5",
                                             "By hand."]  # fmt: skip
    assert "| long | 1.25 |" in sheet.markdown()
    assert '<td class="number">10.5</td>' in sheet.html()
