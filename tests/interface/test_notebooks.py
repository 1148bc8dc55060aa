"""The example notebooks: they run, find what they hide, and are saved with their outputs."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.rigs.notebooks import FOLDER, ROOT, Notebook

pytest.importorskip("pandas", reason="the notebooks need the extra 'diagnosis'")


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Notebook:
    """A notebook's cells, run in a folder; its saved outputs must be those of its cells."""
    saved, now = Notebook.read(FOLDER / name), Notebook.read(FOLDER / name)
    monkeypatch.chdir(folder)
    now.run()
    for old, new in zip(saved.cells, now.cells, strict=True):
        assert [shape(one) for one in old["outputs"]] == [shape(one) for one in new["outputs"]], (
            f"{name}: its outputs are old: python -m tests.rigs.notebooks"
        )
    assert any(
        "image/svg+xml" in one.get("data", {}) for cell in now.cells for one in cell["outputs"]
    )
    return now


def shape(output: dict[str, object]) -> tuple[object, list[str]]:
    """What an output is, without the figures in it."""
    data = output.get("data", {})
    assert isinstance(data, dict)
    return output["output_type"], sorted(data)


@pytest.mark.study
def test_a_csv_of_an_axis_becomes_a_corrected_model_in_six_cells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    notebook = run("axis.ipynb", tmp_path, monkeypatch)
    assert len(notebook.cells) == 6
    found = notebook.names["diagnosis"].findings
    assert found["name"].tolist() == ["following_lag"]
    assert found["size"][0] == pytest.approx(0.02, abs=0.001)
    assert notebook.names["after"].verdict == "nothing_missing"
    assert (tmp_path / "axis-corrected.yaml").is_file()


@pytest.mark.study
def test_two_hidden_faults_are_found_and_corrected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    notebook = run("hidden-faults.ipynb", tmp_path, monkeypatch)
    hidden = {(fault["effect"], fault["component"]) for fault in notebook.names["faults"]}
    found = notebook.names["diagnosis"].findings
    assert set(zip(found["name"], found["component"], strict=True)) == hidden
    *_, last = notebook.cells
    assert "nothing_missing" in last["outputs"][0]["data"]["text/plain"][0]


def test_the_notebooks_are_named_in_the_docs() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    names = {path.name for path in FOLDER.glob("*.ipynb")}
    assert names == {"axis.ipynb", "hidden-faults.ipynb"}
    assert all(f"notebooks/{name}" in page for name in names)
