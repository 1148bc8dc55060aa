"""Where the program lies: in a working copy or in an installed package."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
"""The folder `deltactl`, which holds code, robot files, networks and services."""
IMPORT_ROOT = PACKAGE.parent
"""The folder that `deltactl` is imported from: the working copy, or site-packages."""


def importable(environment: dict[str, str]) -> dict[str, str]:
    """Return `environment` with this program first on the path of a Python process that it starts.

    `python -P -m deltactl...` then runs the same code, however the parent was started.
    """
    path = [str(IMPORT_ROOT), environment.get("PYTHONPATH", "")]
    return environment | {"PYTHONPATH": ":".join(filter(None, path))}
