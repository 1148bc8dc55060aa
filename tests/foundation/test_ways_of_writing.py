"""Files are written through `foundation/plain_file.py`; other ways need a reason."""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Iterator
from pathlib import Path

from benchmarks.structure import ROOT

ROOMS = ("deltactl", "firmware_py", "drivers", "models")
OTHERWISE = {
    "deltactl/foundation/plain_file.py": "is the one way",
    "deltactl/recording/writing/append_file.py": "a recording grows while it runs",
    "deltactl/fleet/task.py": "answers of a fleet are added as they come, a line each",
    "models/training/dataset.py": "samples are added as they are taken, a line each",
    "deltactl/cli/web.py": "the log of a process that runs",
    "drivers/steps/hosts.py": "memory that two processes share, and no text",
    "firmware_py/daemon/listener.py": "an empty file that is locked",
    "deltactl/interface/recordings.py": "a table in a temporary folder of its own",
    "deltactl/interface/simulated.py": "faults in a temporary folder of its own",
    "deltactl/recording/writing/retention.py": "a recording gets another name, and replaces none",
    "firmware_py/daemon/actions.py": "asks for that",
    "deltactl/web/behind/site.py": "the same, and what was made of the recording goes with it",
    "deltactl/web/behind/own_jobs.py": "a job gets another name",
    "deltactl/reference/site.py": "sources of the site, in a folder of their own",
    "drivers/fakes/syscall_trap.py": "the memory of a process, and /dev/null",
}
METHODS = {"write_text", "write_bytes", "savetxt", "tofile", "touch", "sink_parquet", "to_csv"}
WHOLE = {"copy", "copy2", "copyfile", "move", "mkstemp", "NamedTemporaryFile"}
"""Of shutil and tempfile."""
NAMES_OF_OS = {"replace", "rename", "link"}
WRITING_FLAGS = {"O_WRONLY", "O_RDWR", "O_CREAT", "O_APPEND", "O_TRUNC"}
INTO_A_FILE = {"savemat": 0, "savez": 0, "savez_compressed": 0, "save": 0, "write_table": 1}
"""Calls of libraries, and which argument is the file: they may write into one of ours."""
STREAMS = {"out", "stream", "file", "rows"}
"""What such a file of ours, or what is no file, is called in the code."""


def written(tree: ast.AST) -> Iterator[int]:
    """Lines that write, replace or copy a file in a way of their own."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _writes(node):
            yield node.lineno


def _writes(call: ast.Call) -> bool:
    function = call.func
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    owner = getattr(getattr(function, "value", None), "id", "")
    if name == "open" and owner == "os":
        flags = {one.attr for one in ast.walk(call) if isinstance(one, ast.Attribute)}
        return bool(flags & WRITING_FLAGS)
    if name in ("open", "fdopen", "FileIO"):
        return any(set(text) & set("wax+") for text in _modes(call))
    if owner in ("os", "shutil", "tempfile") and name in NAMES_OF_OS | WHOLE:
        return True
    if name in INTO_A_FILE and owner and len(call.args) > INTO_A_FILE[name]:
        return getattr(call.args[INTO_A_FILE[name]], "id", "") not in STREAMS
    return name in METHODS or (name == "rename" and isinstance(function, ast.Attribute))


def _modes(call: ast.Call) -> Iterator[str]:
    """Constant texts among the arguments that are a mode as `open` has them."""
    given = [*call.args, *(one.value for one in call.keywords if one.arg in ("mode", None))]
    for argument in given:
        for one in ast.walk(argument):
            text = getattr(one, "value", None)
            if isinstance(text, str) and text and set(text) <= set("rwaxbt+U"):
                yield text


def test_no_file_is_written_in_another_way() -> None:
    found: dict[str, list[int]] = {}
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            behind_a_link = any((ROOT / parent).is_symlink() for parent in Path(name).parents)
            if not behind_a_link and (lines := list(written(ast.parse(path.read_text())))):
                found[name] = lines
    assert {name: lines for name, lines in found.items() if name not in OTHERWISE} == {}
    assert sorted(set(OTHERWISE) - set(found)) == [], "an exception that nobody needs"


def test_every_other_way_is_seen() -> None:
    ways = """
        path.write_text("a")
        (folder / "a").write_bytes(b"a")
        open(path, "w")
        open(path, mode="a")
        path.open("x", encoding="utf-8")
        path.open("w" if replace else "r")
        gzip.open(path, "wt")
        os.fdopen(descriptor, "wb")
        os.open(path, os.O_WRONLY | os.O_CREAT)
        os.replace(part, path)
        part.rename(path)
        shutil.copyfile(one, other)
        np.savez(path, a=1)
        parquet.write_table(table, str(path))
        tempfile.NamedTemporaryFile(dir=folder)
    """
    lines = textwrap.dedent(ways).strip()
    assert list(written(ast.parse(lines))) == list(range(1, len(lines.split("\n")) + 1))


def test_reading_is_no_writing() -> None:
    lines = 'open(path)\npath.open("rb")\nos.open(path, os.O_RDONLY)\nnp.savez(stream, a=1)\n'
    assert list(written(ast.parse(lines + 'text.replace("w", "a")'))) == []
