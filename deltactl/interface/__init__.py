"""What `import deltactl` offers to a notebook or a script; each file is one class of it.

The package lists the names and imports a file of this folder when one of its names is first used.
"""

import warnings

from deltactl.foundation.release import GONE_IN, NAMES


def older(old: str, calls: int = 1) -> None:
    """Warn that a name of version 0.1 goes, and say when and what replaces it.

    calls: how many of ours lie between this and the user's line, at which the warning points.
    """
    warnings.warn(
        f"deltactl.{old} goes with release {GONE_IN}; use deltactl.{NAMES[old]}",
        DeprecationWarning,
        calls + 2,
    )
