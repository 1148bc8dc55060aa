"""What is believed of a robot, and how new findings change it.

In: the effects a robot file names and those that a recording shows beyond them. Out: one list of
effects, each size with where it comes from.
"""

from __future__ import annotations

from deltactl.models.belief.merge import merged

__all__ = ["merged"]
