"""The shape of the source: lines, files, import circles, numbers that decide an answer.

    python -m benchmarks.structure [--root DIR] [--folder deltactl/diagnosis]

Lines and files are those of Python below --folder, by room. A circle is a set of rooms that import
each other, directly or around a corner, wherever in a file the import stands. A room is a folder
without folders in it; the loose files of a folder that has some stand for themselves. A number that
decides is a constant in capitals at the top of a file of --folder, or a field with a default of a
class called ...Options or EffectKind, whose value is a number or holds numbers; those of such a
class stand in a table, where their reasons stand beside them. The last lines are the size of the
whole source (`benchmarks/size.py`).
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from benchmarks.size import CRUMB_LINES, figures

ROOT = Path(__file__).resolve().parents[1]
NOT_SHIPPED = ("tests", "docs", "build", "benchmarks")
NO_CRUMBS = ("models/effects/", "deltactl/__main__.py")
"""There one file is one effect, however short, and what `python -m` runs stands alone."""
NOT_DECIDING = ("report", "drawing")
"""Rooms whose numbers are of words and pictures."""


def packages(root: Path) -> list[Path]:
    """Folders of the source at the top."""
    tops = sorted(path for path in root.iterdir() if path.is_dir() and path.name[0] != ".")
    return [top for top in tops if top.name not in NOT_SHIPPED and any(top.glob("*.py"))]


def room_of(root: Path, file: Path) -> str:
    """The room of a file, or the file itself where it is loose beside rooms."""
    folder = file.parent
    parts = folder.relative_to(root).parts
    if any(any(other.glob("*.py")) for other in folder.iterdir() if other.is_dir()):
        return ".".join((*parts, file.stem))
    return ".".join(parts)


def module_name(root: Path, file: Path) -> str:
    """How a file is imported: a folder that the package links to is a part of the package."""
    parts = file.relative_to(root).with_suffix("").parts
    linked = (root / "deltactl" / parts[0]).is_symlink()
    return ".".join(("deltactl", *parts) if linked else parts)


def imports(root: Path) -> dict[str, dict[str, list[str]]]:
    """Room -> rooms that it imports -> files that do so."""
    found: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    imported = _imported(root)
    rooms = {file: room_of(root, file) for file in imported}
    for file, others in imported.items():
        room = rooms[file]
        for other in others:
            if (its := rooms[other]) != room:
                found[room][its].append(str(file.relative_to(root)))
    return {room: dict(others) for room, others in found.items()}


def file_imports(root: Path) -> dict[str, dict[str, None]]:
    """File -> files that it imports; what a package's `__init__` imports is left out."""
    names = {
        str(file.relative_to(root)): {str(other.relative_to(root)): None for other in others}
        for file, others in _imported(root).items()
    }
    return {name: others for name, others in names.items() if not name.endswith("__init__.py")}


def crumbs(root: Path) -> list[str]:
    """Files of at most CRUMB_LINES that at most one other file imports."""
    imported = file_imports(root)
    users = Counter(name for others in imported.values() for name in others)
    alone = [name for name in sorted(imported) if users[name] <= 1]
    lines = {name: (root / name).read_text(encoding="utf-8").count("\n") for name in alone}
    return [n for n in alone if lines[n] <= CRUMB_LINES and not n.startswith(NO_CRUMBS)]


def _imported(root: Path) -> dict[Path, set[Path]]:
    """Every file of the source, and the files that it imports."""
    files = [file for top in packages(root) for file in sorted(top.rglob("*.py"))]
    known = {module_name(root, file): file for file in files}
    known |= {name.removesuffix(".__init__"): file for name, file in known.items()}
    return {
        file: {known[name] for name in _named(file.read_text(encoding="utf-8")) if name in known}
        - {file}
        for file in files
    }


@cache
def _named(text: str) -> frozenset[str]:
    """Every module that a file imports; of `from a import b` both a.b and a may be one."""
    named: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            named |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            named |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(named)


def circles(edges: Mapping[str, Mapping[str, object]]) -> list[list[str]]:
    """Sets of rooms that reach each other."""
    reach = {room: _reached(edges, room) for room in edges}
    found = {
        tuple(sorted({room} | {o for o in reach[room] if room in reach.get(o, ())}))
        for room in reach
        if room in reach[room]
    }
    return [list(circle) for circle in sorted(found)]


def between_folders(root: Path) -> list[list[str]]:
    """The circles of a repository that leave one folder: its loose files may know each other."""

    def folder(name: str) -> str:
        loose = root.joinpath(*name.split(".")).with_suffix(".py").exists()
        return name.rpartition(".")[0] if loose else name

    return [
        circle for circle in circles(imports(root)) if len({folder(name) for name in circle}) > 1
    ]


def _reached(edges: Mapping[str, Mapping[str, object]], start: str) -> set[str]:
    seen: set[str] = set()
    waiting = list(edges.get(start, ()))
    while waiting:
        room = waiting.pop()
        if room not in seen:
            seen.add(room)
            waiting += edges.get(room, ())
    return seen


def deciding(folder: Path) -> list[str]:
    """Names of the numbers below a folder that decide an answer, one for each definition."""
    return [name for name, _ in _defined(folder)]


def in_tables(folder: Path) -> list[str]:
    """Those of them that stand in a table of options or at the effect."""
    return [name for name in deciding(folder) if name[0].islower()]


def at_odds(folder: Path) -> list[str]:
    """Names of such numbers that mean one thing in one file and another in the next."""
    values: dict[str, set[str]] = defaultdict(set)
    for name, value in _defined(folder):
        values[name].add(value)
    return sorted(name for name, several in values.items() if len(several) > 1)


def _defined(folder: Path) -> list[tuple[str, str]]:
    files = [f for f in sorted(folder.rglob("*.py")) if not set(f.parts) & set(NOT_DECIDING)]
    return [found for file in files for found in _numbers(ast.parse(file.read_text("utf-8")))]


def _numbers(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Names and values."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name.endswith(("Options", "EffectKind")):
            yield from (
                number for part in node.body for number in _assigned(part) if number[0].islower()
            )
        yield from (number for number in _assigned(node) if number[0].isupper())


def _assigned(node: ast.stmt) -> Iterator[tuple[str, str]]:
    """Names that get a number, or something with numbers in it, and what they get."""
    if isinstance(node, ast.Assign):
        targets, value = node.targets, node.value
    elif isinstance(node, ast.AnnAssign) and node.value is not None:
        targets, value = [node.target], node.value
    else:
        return
    if not any(
        isinstance(part, ast.Constant) and type(part.value) in (int, float)
        for part in ast.walk(value)
    ):
        return
    for target in targets:
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        yield from ((n.id, ast.dump(value)) for n in names if isinstance(n, ast.Name))


def main() -> int:
    """Exit status 1 when there is a circle."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--root", type=Path, default=ROOT)
    parser.add_argument("--folder", default="deltactl/diagnosis")
    options = parser.parse_args()
    root, folder = options.root.resolve(), options.root.resolve() / options.folder
    files, lines = Counter[str](), Counter[str]()
    for file in sorted(folder.rglob("*.py")):
        room = ".".join(file.parent.relative_to(root).parts)
        files[room] += 1
        lines[room] += len(file.read_text(encoding="utf-8").splitlines())
    for room, count in files.items():
        print(f"{room:32s} {count:3d} files {lines[room]:6d} lines")
    print(f"{'all':32s} {files.total():3d} files {lines.total():6d} lines")
    names = Counter(deciding(folder))
    again = [name for name, count in names.items() if count > 1]
    print(f"numbers: {names.total()}, {len(in_tables(folder))} of them in tables")
    print(f"names defined more than once: {', '.join(again) or 'none'}")
    found = between_folders(root)
    for circle in found:
        print(f"import circle: {', '.join(circle)}")
    print(f"{len(found)} import circles")
    from deltactl.models.effects import CARDS

    for what, much in figures(root, CARDS):
        print(f"{what:32s} {much}")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
