"""What is noted of one fault."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tests.rigs.faults.edges import Int64Array

HEARTBEAT_S = 0.25
"""steps.heartbeat_s of the robot file."""
MINIMUM_GAP = 0.9
"""steps.minimum_gap_fraction of the robot file."""
CLOCK_NS = 30_000
"""The drives note an edge where it arrives, the player where it was written: a process that is
taken off its core between the two makes them differ by more than this only rarely."""

NO_CORE_S = 0.1
"""Whoever waited longer than this, with all threads, shared the machine with too much else."""


@dataclass
class Verdict:
    """Figures of one fault, and in words what was not as specified."""

    kind: str
    last_edge_s: float = 0.0
    """From the fault to the last edge; going on: to all being well again."""
    seen_s: float = 0.0
    pause_s: float = 0.0
    """Longest pause of the pulses of a robot that went on."""
    gap_part: float = np.inf
    """Shortest gap between two edges, as part of the step period."""
    miscounted: int = 0
    unrecorded_s: float = 0.0
    waited_s: float = 0.0
    """How long our threads together wanted to run meanwhile and had no core."""
    problems: list[str] = field(default_factory=list)

    @property
    def counts(self) -> bool:
        """Whether what is wrong is the program's own: it had a core when it wanted one."""
        return bool(self.problems) and self.waited_s < NO_CORE_S

    def demand(self, holds: bool, problem: str) -> None:
        """Note a problem unless it holds."""
        if not holds:
            self.problems.append(problem)


def judge_gaps(verdict: Verdict, times_ns: Int64Array, period_ns: int) -> None:
    """Note the shortest gap between edges of a path stepped with this period."""
    if len(times_ns) > 1:
        verdict.gap_part = float(np.diff(times_ns).min()) / period_ns
        least = MINIMUM_GAP - CLOCK_NS / period_ns
        verdict.demand(verdict.gap_part >= least, f"gap of {verdict.gap_part:.3f} of a period")
