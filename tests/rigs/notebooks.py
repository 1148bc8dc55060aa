"""Notebooks run cell by cell, and their outputs, without a Jupyter kernel.

A cell's printed text and the value of its last expression are its outputs, in the formats that the
value offers (`_repr_svg_`, `_repr_html_`, text), as a notebook displays them. Does not model: magic
commands, `display()`, widgets, and a kernel's own process. `python -m tests.rigs.notebooks` writes
the outputs into the notebooks.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "notebooks"
RICH = {"image/svg+xml": "_repr_svg_", "text/html": "_repr_html_"}

Json = dict[str, Any]


@dataclass
class Notebook:
    """The file, as JSON, and the names that its cells have made."""

    path: Path
    json: Json
    names: Json = field(default_factory=lambda: {"__name__": "__main__"})

    @classmethod
    def read(cls, path: Path) -> Notebook:
        """Read a notebook file (nbformat 4)."""
        return cls(path, json.loads(path.read_text(encoding="utf-8")))

    @property
    def cells(self) -> list[Json]:
        """Its cells of code."""
        return [cell for cell in self.json["cells"] if cell["cell_type"] == "code"]

    def run(self) -> None:
        """Run all cells in the current folder and put their outputs in place.

        What a cell raises goes through, with its number in the traceback.
        """
        for number, cell in enumerate(self.cells, 1):
            cell["execution_count"] = number
            cell["outputs"] = self._outputs("".join(cell["source"]), number)

    def write(self) -> None:
        """Write the file, as Jupyter does."""
        text = json.dumps(self.json, indent=1, ensure_ascii=False, sort_keys=True)
        self.path.write_text(text + "\n", encoding="utf-8")

    def _outputs(self, source: str, number: int) -> list[Json]:
        printed, name = io.StringIO(), f"cell {number} of {self.path.name}"
        tree, last = ast.parse(source, name), None
        if tree.body and isinstance(tree.body[-1], ast.Expr):
            last = ast.Expression(tree.body.pop().value)  # type: ignore[attr-defined]
        with contextlib.redirect_stdout(printed):
            exec(compile(tree, name, "exec"), self.names)
            value = None if last is None else eval(compile(last, name, "eval"), self.names)
        outputs: list[Json] = []
        if text := printed.getvalue():
            outputs.append({"name": "stdout", "output_type": "stream", "text": _lines(text)})
        if value is not None and not source.rstrip().endswith(";"):
            outputs.append(
                {
                    "data": _bundle(value),
                    "execution_count": number,
                    "metadata": {},
                    "output_type": "execute_result",
                }
            )
        return outputs


def _bundle(value: object) -> Json:
    """A value in each format that it offers."""
    bundle: Json = {"text/plain": _lines(repr(value))}
    for kind, method in RICH.items():
        if (shown := getattr(value, method, None)) is not None and (text := shown()) is not None:
            bundle[kind] = _lines(text)
    return bundle


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def main() -> None:
    """Run every notebook in a folder of its own and save its outputs."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        notebook = Notebook.read(path)
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            notebook.run()
        notebook.write()
        print(f"{os.path.relpath(path, ROOT)}: {len(notebook.cells)} cells")


if __name__ == "__main__":
    main()
