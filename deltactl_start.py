"""Where the program begins: its own packages are found in its own folder, whatever is called alike.

Its folders have everyday names (`web`, `models`, `recording`). A folder of the reader's with one
of those names, in PYTHONPATH or where `python -m` is typed, would be imported in its place. So this
module, whose name nobody else uses, puts the program's own packages before anything on the path.
"""

from __future__ import annotations

import os
import re
import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from typing import Any

HOME = Path(__file__).resolve().parent
"""Of a working copy: its folder. Of an installed wheel: site-packages."""
_PACKAGE = re.compile(r"^(\w+)/__init__\.py,", re.MULTILINE)


def own_packages(home: Path) -> frozenset[str]:
    """Top-level packages of the program: a wheel lists its files, a working copy holds no others.

    Others in site-packages are left to the path: who sets PYTHONPATH may mean another numpy.
    """
    for record in home.glob("deltactl-*.dist-info/RECORD"):
        return frozenset(_PACKAGE.findall(record.read_text(encoding="utf-8")))
    return frozenset(file.parent.name for file in home.glob("*/__init__.py"))


class OwnPackages(MetaPathFinder):
    """Finds the program's top-level packages in its own folder, and nothing else."""

    def __init__(self, home: Path):
        self._home = str(home)
        self._names = own_packages(home)

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        """See MetaPathFinder; what lies inside a package is found through the package."""
        if fullname not in self._names:
            return None
        return PathFinder.find_spec(fullname, [self._home], target)


def own_packages_first() -> None:
    """From here on, in this process and in Python processes that it starts."""
    if any(isinstance(one, OwnPackages) for one in sys.meta_path):
        return
    sys.meta_path.insert(0, OwnPackages(HOME))
    if path := os.environ.get("PYTHONPATH"):
        os.environ["PYTHONPATH"] = os.pathsep.join([str(HOME), path])


def main() -> None:
    """Run the command line; used by the `deltactl` script."""
    own_packages_first()
    from command_line.main import main as command_line

    command_line()
