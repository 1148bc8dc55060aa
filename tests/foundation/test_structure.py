"""The source has no import circles between its rooms, and the command that says so sees one."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.mutation.mistakes import NAMED, TABLE
from benchmarks.size import MARK, branches, complexity, figures, parameters, program, prose
from benchmarks.structure import (
    ROOT,
    at_odds,
    between_folders,
    circles,
    crumbs,
    deciding,
    file_imports,
    imports,
    packages,
)


def test_no_rooms_import_each_other() -> None:
    assert between_folders(ROOT) == []


def test_a_circle_around_a_corner_is_seen(tmp_path: Path) -> None:
    for room, text in {
        "one": "from two import thing",
        "two": "def late():\n    import three.thing",
        "three": "from one.thing import thing",
        "four": "import one.thing",
    }.items():
        (tmp_path / room).mkdir()
        (tmp_path / room / "__init__.py").touch()
        (tmp_path / room / "thing.py").write_text(text)
    assert circles(imports(tmp_path)) == [["one", "three", "two"]]


def test_loose_files_beside_rooms_stand_for_themselves(tmp_path: Path) -> None:
    (tmp_path / "roof" / "room").mkdir(parents=True)
    (tmp_path / "roof" / "base.py").write_text("")
    (tmp_path / "roof" / "top.py").write_text("import roof.room.inner")
    (tmp_path / "roof" / "room" / "inner.py").write_text("import roof.base")
    assert between_folders(tmp_path) == []
    (tmp_path / "roof" / "base.py").write_text("import roof.top")
    assert len(between_folders(tmp_path)) == 1


def test_numbers_that_decide_are_counted(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(
        'LIMIT = 3.0\nNAME = "x"\nclass SearchOptions:\n    most: int = 4'
    )
    assert deciding(tmp_path) == ["LIMIT", "most"]
    (tmp_path / "b.py").write_text("LIMIT = 4.0\nmost = 5")
    assert at_odds(tmp_path) == ["LIMIT"]


def test_no_number_of_the_diagnosis_has_a_second_value_elsewhere() -> None:
    assert at_odds(ROOT / "deltactl" / "diagnosis") == []


CRUMBS = 4
"""Files under 60 lines that one other file imports: most belong into it. It may only shrink."""


def test_layers() -> None:
    """The contracts in pyproject.toml."""
    done = subprocess.run(
        ["lint-imports", "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT), "PATH": _with_scripts()},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout


def _with_scripts() -> str:
    return os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])


def test_no_files_import_each_other() -> None:
    assert circles(file_imports(ROOT)) == []


def test_crumbs_become_fewer() -> None:
    found = crumbs(ROOT)
    assert len(found) <= CRUMBS, found


MARKS = 35
"""Marks that switch the formatter off, without those of tests: tables. It may only shrink."""


def test_the_formatter_is_switched_off_less_and_less() -> None:
    assert sum(text.count(MARK) for text in program(ROOT).values()) <= MARKS


SOURCE = '''"""A docstring."""
def ways(self, a, b, *, c):
    for one in [x for x in a if x and b]:
        try:
            print("two words" if one else "word")
        except ValueError:
            pass
'''


def test_ways_through_a_function_are_counted() -> None:
    """The function, a loop, a comprehension with its condition, an `and`, an `except`, an `if`."""
    tree = ast.parse(SOURCE)
    (function,) = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    assert complexity(function) == 7
    assert parameters(function) == 3
    assert branches(tree) == 2
    assert prose(tree) == 1


def test_the_size_of_a_program_leaves_out_tests_and_links(tmp_path: Path) -> None:
    for name in ("deltactl/diagnosis/report", "models", "tests"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "deltactl" / "models").symlink_to(tmp_path / "models")
    (tmp_path / "models" / "a.py").write_text(f"a = [1,2]  {MARK}\n")
    (tmp_path / "deltactl" / "__init__.py").write_text("")
    (tmp_path / "deltactl" / "diagnosis" / "report" / "b.py").write_text(SOURCE)
    (tmp_path / "tests" / "c.py").write_text(f"c = ('one', 'two')  {MARK}\n" * 2)
    (tmp_path / "pyproject.toml").write_text(
        '[tool.setuptools.packages.find]\ninclude = ["deltactl*"]\n'
    )
    found = dict(figures(tmp_path, {"one", "two"}))
    assert found["Python without tests"] == "8 lines, 3 files, 3 folders"
    assert found["its report"] == "7 lines, 2 branches, 1 prose literals"
    assert found["names in site-packages"] == "1"
    assert found[MARK] == "1, and 2 in tests"


@pytest.mark.parametrize("top", [ROOT / "benchmarks", *packages(ROOT)], ids=lambda top: top.name)
def test_a_folder_says_what_comes_in_and_goes_out(top: Path) -> None:
    for room in sorted({file.parent for file in top.rglob("*.py")}):
        said = ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8")))
        assert said, room


@pytest.mark.study
def test_every_number_in_a_table_has_its_reason() -> None:
    """Below the field, or below the next where two belong together."""
    bare = []
    for file in sorted((ROOT / "deltactl" / "diagnosis").rglob("*.py")):
        for table in ast.parse(file.read_text("utf-8")).body:
            if isinstance(table, ast.ClassDef) and table.name.endswith("Options"):
                said = [_is_words(part) for part in table.body] + [False, False]
                bare += [
                    f"{file.name}: {table.name}.{ast.unparse(part.target)}"
                    for at, part in enumerate(table.body)
                    if isinstance(part, ast.AnnAssign) and not (said[at + 1] or said[at + 2])
                ]
    assert bare == []


def _is_words(part: ast.stmt) -> bool:
    return isinstance(part, ast.Expr) and isinstance(part.value, ast.Constant)


def test_mistakes_are_put_where_something_stands() -> None:
    """A file or line that was renamed would drop out of the mutation run without a word."""
    files = {f"{row.folder}/{name}" for row in TABLE for name in row.files}
    files |= {test for row in TABLE for test in row.tests} | {one.path for one in NAMED}
    assert not [name for name in sorted(files) if not (ROOT / name).exists()]
    moved = [one for one in NAMED if (ROOT / one.path).read_text().count(one.was) != 1]
    assert not moved, "benchmarks/mutation/named.yaml quote lines of the program"
