"""What `import deltactl` offers to a notebook or a script; each file is one class of it.

The package lists the names and imports a file of this folder when one of its names is first used.
"""

import warnings


def older(old: str, new: str) -> None:
    """Warn that a name of version 0.1 goes with the next release, and name what replaces it."""
    warnings.warn(
        f"deltactl.{old} goes with the next release; use deltactl.{new}", DeprecationWarning, 3
    )
