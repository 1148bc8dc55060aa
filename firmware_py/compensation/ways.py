"""Which effects are compensated in which way."""

from __future__ import annotations

AHEAD = frozenset({"following_lag", "viscous_friction"})
"""Drives that follow late are commanded ahead of time (`lead`)."""
AT_REVERSALS = frozenset({"gear_backlash", "joint_friction"})
"""Play and wound-up shafts are taken up where an arm turns round (`remembering`)."""
WARMING = frozenset({"thermal_expansion"})
"""Growth is followed with its time constant (`remembering`)."""
RINGING = frozenset({"resonance"})
"""What rings is moved so that it does not (`ringing`)."""
