"""What the pulse player must know, in plain numbers that travel to the pulse process as JSON."""

from __future__ import annotations

from typing import NamedTuple


class PlayerSettings(NamedTuple):
    """Timing in ns; masks have a bit for each motor, or for each input line (see lines.py)."""

    pulse_width_ns: int
    direction_setup_ns: int
    minimum_gap_fraction: float
    heartbeat_ns: int
    inverted: int
    """Motors whose positive direction is a low DIR."""
    enable_level: int
    """Level of ENA that energises the drives."""
    input_mask: int
    """Inputs that exist."""
    input_idle: int
    """Levels of the inputs while nothing is wrong."""
    poll_ns: int
    """While waiting for a tick, requests and inputs are looked at this often."""
    check_ahead_ns: int = 0
    """The last look at them comes so long before an edge; 0 is right at the edge."""
    switch_mask: int = 0
    """Outputs that jobs switch, bits as in lines.py."""
    switch_safe: int = 0
    """Their levels whenever the player is stopped or the drives are released."""

    @property
    def cycle_ns(self) -> int:
        """Shortest time between two steps that pulse width, low time and DIR set-up leave."""
        return 2 * self.pulse_width_ns + self.direction_setup_ns
