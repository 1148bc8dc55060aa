"""Which files may be read for an assistant: those of one folder, and what the program ships."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from deltactl.firmware_py.named_files import CONFIG_FOLDER, find
from deltactl.foundation.errors import ForbiddenPath, MissingFile
from deltactl.foundation.process import PACKAGE

DEVICES = ("/dev", "/proc", "/sys")
"""What Python and its libraries look at to know the machine."""
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def inside(root: Path, named: str) -> str:
    """A file that was named, by its place below the root, with links followed.

    Raises
    ------
    ForbiddenPath
        It lies elsewhere; whether it is there is not said.
    MissingFile
        There is no such file.
    """
    folder = root.resolve()
    try:
        place = (folder / named).resolve()
    except (OSError, ValueError, RuntimeError):  # a NUL in the name, a circle of links
        raise MissingFile(f"{_short(named)}: is no name of a file; give one in {folder}") from None
    if not place.is_relative_to(folder):
        raise ForbiddenPath(
            f"{_short(named)}: lies outside {folder}, and only files there may be read; copy it"
            " there, or start 'deltactl mcp' with --root and its folder"
        )
    try:
        there = place.is_file()
    except OSError:  # a name that is too long
        there = False
    if not there:
        raise MissingFile(f"{_short(named)}: no such file in {folder}; {_others(folder, place)}")
    return str(place.relative_to(folder))


def robot_file(root: Path, named: str) -> str:
    """A robot file below the root, or one of the program's own by its plain name.

    Raises what `inside` raises.
    """
    plain = Path(named).name == named
    if plain and not (root / named).exists() and (CONFIG_FOLDER / named).is_file():
        return str(find(named))
    return inside(root, named)


def _others(folder: Path, place: Path) -> str:
    """What there is beside a file that is not there."""
    beside = place.parent if place.parent.is_dir() else folder
    names = sorted(one.name for one in beside.iterdir() if one.is_file())[:10]
    return f"name one that is there: {', '.join(names)}" if names else "no file is there"


def _short(named: str) -> str:
    return named if len(named) <= 100 else f"{named[:100]}..."


def read_only(root: Path) -> None:
    """Hold this process to reading below the root, and to Python's own files.

    A file may name others (the model of a chain, what a YAML file includes), and a link may be
    exchanged after it was looked at: each file that Python opens is looked at again. It lasts as
    long as the process; ForbiddenPath is raised where a file is opened.
    """
    sys.dont_write_bytecode = True
    own: tuple[str | Path, ...] = (
        root,
        PACKAGE,
        *PACKAGE.iterdir(),  # links, in a checkout
        CONFIG_FOLDER,
        sys.prefix,
        sys.base_prefix,
        "/usr",
        *sys.path,
        *DEVICES,
    )
    allowed = tuple({os.path.realpath(one) for one in own if str(one)})

    def look(event: str, given: tuple[Any, ...]) -> None:
        if event != "open" or not isinstance(given[0], str | bytes | os.PathLike):
            return
        place = os.path.realpath(os.fsdecode(given[0]))
        mode, flags = given[1], given[2]
        writes = flags & WRITING if isinstance(flags, int) else set(mode or "") & set("wax+")
        if writes and not _below(place, DEVICES):
            raise ForbiddenPath(f"{place}: would be written; nothing is written for an assistant")
        if not _below(place, allowed):
            raise ForbiddenPath(
                f"{place}: lies outside {root}, and only files there may be read; copy it there"
            )

    sys.addaudithook(look)


def _below(place: str, folders: tuple[str, ...]) -> bool:
    return any(place == one or place.startswith(one.rstrip("/") + "/") for one in folders)
