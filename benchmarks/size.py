"""The size of the source, as `python -m benchmarks.structure` prints it and docs/decisions/size.md
quotes it: a line for each figure.

Lines are those of Python, each file by its real path alone. A branch is an `if`, a conditional
expression, or an `and` or `or`; prose is a text with a space that is no docstring. Complexity is
one, and one for every `if`, loop, `except`, `case`, conditional expression, `and` or `or`,
comprehension and condition in it; `self` is no parameter. Effect names are string literals that
are the name of an effect, alone or before a dot; a table is a literal with three or more of them.
"""

from __future__ import annotations

import ast
import fnmatch
import tomllib
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path

CRUMB_LINES = 60
MOST_COMPLEX, MOST_PARAMETERS = 15, 7
MARK = "# fmt: " + "skip"
"""Switches the formatter off; written in two, as it would do so here."""
EFFECTS = Path("models/effects")
BLIND = (Path("deltactl/proof"), Path("benchmarks/rivals"))
"""The blind proof shares no code with the models, and other tools run where deltactl is not
installed: both say what they hide by the contract's names."""
COMMAND_LINE = "deltactl/cli/"
Sources = dict[str, str]
"""Path below the root -> text."""
Function = ast.FunctionDef | ast.AsyncFunctionDef
_BRANCHES = (ast.If, ast.IfExp, ast.BoolOp)
_LOOPS = (ast.For, ast.AsyncFor, ast.While, ast.ExceptHandler, ast.match_case, ast.comprehension)
_LITERALS = (ast.Dict, ast.Tuple, ast.List, ast.Set)


def sources(root: Path) -> Sources:
    """Every Python file, but for those behind a link and in hidden or built folders."""
    found = {path.name: path.read_text(encoding="utf-8") for path in sorted(root.glob("*.py"))}
    for top in sorted(root.iterdir()):
        if top.is_dir() and not top.name.startswith(".") and top.name != "build":
            for path in sorted(top.rglob("*.py")):
                inside = path.relative_to(root)
                if not any((root / part).is_symlink() for part in inside.parents):
                    found[inside.as_posix()] = path.read_text(encoding="utf-8")
    return found


def program(root: Path) -> Sources:
    """All but the tests."""
    return {name: t for name, t in sources(root).items() if not name.startswith("tests/")}


def below(files: Sources, *folders: str) -> Sources:
    """Those of them in folders."""
    return {name: text for name, text in files.items() if name.startswith(folders)}


def lines(files: Sources) -> int:
    """Lines of them together."""
    return sum(text.count("\n") for text in files.values())


def branches(tree: ast.AST) -> int:
    """How often a source decides."""
    return sum(isinstance(node, _BRANCHES) for node in ast.walk(tree))


def prose(tree: ast.AST) -> int:
    """Texts with a space that are no docstrings."""
    nodes = list(ast.walk(tree))
    said = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    texts = (n.value for n in nodes if isinstance(n, ast.Constant) and id(n) not in said)
    return sum(isinstance(text, str) and " " in text for text in texts)


def complexity(function: Function) -> int:
    """Ways through a function, with those of functions inside it."""
    nodes = list(ast.walk(function))
    conditions = sum(len(node.ifs) for node in nodes if isinstance(node, ast.comprehension))
    return 1 + conditions + sum(isinstance(node, (*_BRANCHES, *_LOOPS)) for node in nodes)


def parameters(function: Function) -> int:
    """Parameters that have a name, without `self`."""
    given = function.args
    named = [one.arg for one in (*given.posonlyargs, *given.args)]
    return len(named) + len(given.kwonlyargs) - (named[:1] in (["self"], ["cls"]))


def functions(files: Sources) -> Iterator[tuple[str, Function]]:
    """Files and their functions and methods."""
    for name, text in files.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, Function):
                yield name, node


def effect_names(text: str, effects: Collection[str]) -> list[str]:
    """Names of effects among the literals of a source, also as keys like 'gear_ratio.small'."""
    literals = (node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant))
    names = (one.partition(".")[0] for one in literals if isinstance(one, str))
    return [name for name in names if name in effects and name != "unknown"]


def outside_the_cards(files: Sources, effects: Collection[str]) -> Counter[str]:
    """Effect names by file, of files outside models/effects; `unknown` names no effect."""
    apart = tuple(f"{folder.as_posix()}/" for folder in (EFFECTS, *BLIND))
    there = {name: text for name, text in files.items() if not name.startswith(apart)}
    return +Counter({name: len(effect_names(text, effects)) for name, text in there.items()})


def tables(text: str, effects: Collection[str]) -> int:
    """Literals of a source with three effect names or more."""

    def named(node: ast.AST) -> int:
        parts = (p.value for p in ast.iter_child_nodes(node) if isinstance(p, ast.Constant))
        return sum(part in effects for part in parts)

    nodes = ast.walk(ast.parse(text))
    return sum(isinstance(node, _LITERALS) and named(node) >= 3 for node in nodes)


def installed(root: Path) -> list[str]:
    """Names that `pip install .` puts into site-packages, beside the distribution's own record."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    asked = project["tool"]["setuptools"]
    patterns = asked["packages"]["find"]["include"]
    tops = sorted(path.parent.name for path in root.glob("*/__init__.py"))
    packages = [top for top in tops if any(fnmatch.fnmatch(top, pattern) for pattern in patterns)]
    return [*packages, *asked.get("py-modules", [])]


def figures(root: Path, effects: Collection[str]) -> Iterator[tuple[str, str]]:
    """What is counted, and how much of it there is; import circles are not among them."""
    files, tests = program(root), below(sources(root), "tests/")
    folders = {Path(name).parent for name in files}
    yield (
        "Python without tests",
        f"{lines(files)} lines, {len(files)} files, {len(folders)} folders",
    )
    diagnosis = below(files, "deltactl/diagnosis/", "deltactl/recording/foreign/", "diagnosis/")
    yield "diagnosis, readers of tables", f"{lines(diagnosis)} lines, {len(diagnosis)} files"
    report = below(files, "deltactl/diagnosis/report/", "diagnosis/report/")
    trees = [ast.parse(text) for text in report.values()]
    yield (
        "its report",
        (
            f"{lines(report)} lines, {sum(map(branches, trees))} branches,"
            f" {sum(map(prose, trees))} prose literals"
        ),
    )
    named = outside_the_cards(files, effects)
    count = sum(tables(files[name], effects) for name in named)
    yield "effect names elsewhere", f"{named.total()} in {len(named)} files, {count} tables"
    yield "names in site-packages", str(len(installed(root)))
    short = sum(text.count("\n") <= CRUMB_LINES for text in files.values())
    yield f"files of at most {CRUMB_LINES} lines", str(short)
    marks = sum(text.count(MARK) for text in files.values())
    yield MARK, f"{marks}, and {sum(text.count(MARK) for text in tests.values())} in tests"
    made = list(functions(files))
    complex_ = sum(complexity(function) > MOST_COMPLEX for _, function in made)
    yield f"functions, complexity over {MOST_COMPLEX}", str(complex_)
    many = [name for name, function in made if parameters(function) > MOST_PARAMETERS]
    commands = sum(name.startswith(COMMAND_LINE) for name in many)
    yield (
        f"functions, parameters over {MOST_PARAMETERS}",
        f"{len(many) - commands}, and {commands} of the command line",
    )
