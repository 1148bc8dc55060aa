"""Parts of the program that a small install leaves out, and the command that adds them here."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from deltactl.foundation.errors import MissingExtra
from deltactl.foundation.process import IMPORT_ROOT


@contextmanager
def needs(extras: str, what: str) -> Iterator[None]:
    """Imports under this raise MissingExtra, which says what to type, where a package is missing.

    `extras` are those of pyproject.toml, with commas between them; `what` asked for them.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise missing(what, error, extras) from error


def missing(what: str, error: ModuleNotFoundError, extras: str) -> MissingExtra:
    """What to say of a package that was not found, and what to type."""
    return MissingExtra(
        f"{what} needs {error.name}, which is not installed; type: {how_to_install(extras)}"
    )


def how_to_install(extras: str) -> str:
    """The command that adds extras to the Python that runs this program."""
    if (IMPORT_ROOT / "Makefile").is_file():
        at = "" if Path.cwd() == IMPORT_ROOT else f"-C {IMPORT_ROOT} "
        venv = Path(sys.prefix)
        usual = "" if venv == IMPORT_ROOT / ".venv" else f" VENV={venv}"
        return f"make {at}extras WITH={extras}{usual}"
    packages = " ".join(f"'{name}'" for name in _packages(extras.split(",")))
    if (Path(sys.prefix) / "pipx_metadata.json").is_file():
        return f"pipx inject deltactl {packages}"
    from importlib import util

    if util.find_spec("pip") is not None:
        return f"{sys.executable} -m pip install {packages}"
    return f"python3 -m pip --python {sys.executable} install {packages}"


def _packages(extras: list[str]) -> list[str]:
    """What the extras of the installed program ask for on this machine."""
    from importlib import metadata

    from packaging.requirements import Requirement

    found: list[str] = []
    for text in metadata.requires("deltactl") or ():
        wanted = Requirement(text)
        if wanted.marker is None or wanted.marker.evaluate({"extra": ""}):
            continue
        if not any(wanted.marker.evaluate({"extra": extra}) for extra in extras):
            continue
        if wanted.name == "deltactl":
            found += _packages(sorted(wanted.extras))
        else:
            found.append(f"{wanted.name}{wanted.specifier}")
    return sorted(set(found))
