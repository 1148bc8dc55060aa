"""What is assumed of a single machine before its recording: how far its robot file may be off.

Odds of effects are on their cards; spreads of what is not in the file are in `options`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LoneOddsOptions:
    """Natural logarithms of prior odds that are on no effect's card."""

    wave_below_a_step: float = -3.0
    """For a wave that is smaller than a step of the reading, in addition: it shows only through
    what lifts readings over their steps, and the hops of an axis that sticks lift them too."""


@dataclass(frozen=True, slots=True)
class FileSpreadOptions:
    """By how much a robot file is off, as a share, where nobody measured."""

    inertia_share: float = 0.3
    """Part weights and drawings."""
    gain_share: float = 0.3
    """Drive makers give 10 % for a torque constant, and state it by rms or by peak amperes, which
    differ by a factor of 1.41."""
    stepper_ratio_share: float = 0.02
    """Belts and rollers slip a little, wheels are turned to a hundredth."""
    servo_ratio_share: float = 0.01
    """A servo closes its loop over what is read: only another encoder sees another ratio."""
    range_scale_share: float = 0.02
    """A distance sensor's clock is off by parts in a thousand, its optics by a percent or two."""


ODDS = LoneOddsOptions()
FILE_SPREADS = FileSpreadOptions()
"""As the engine is used."""
