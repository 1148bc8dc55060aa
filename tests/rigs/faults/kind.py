"""What a kind of fault is, and what is specified for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from tests.rigs.faults.stand import Stand

Undo = Callable[[], None]


def nothing() -> None:
    """Nothing has to be undone."""


@dataclass(frozen=True)
class Kind:
    """One row of the table.

    inject: makes the fault, returns what takes its cause away.
    ends: the state the run ends in; empty when the robot must go on.
    within_s: from the fault to the last edge, or, going on, to all being well again.
    seen_s: from the fault to the state saying so.
    culprit: pattern that the reason, an event or the recording's error must match.
    refusal: pattern of the refused acknowledgement while the cause is there; empty: not refused.
    """

    name: str
    inject: Callable[[Stand, Random], Undo]
    ends: str = ""
    within_s: float = 1.0
    seen_s: float = 0.2
    culprit: str = ""
    refusal: str = ""
    restart: bool = False
    """The controller has to be started again afterwards."""
    cuts_recording: bool = False
    """The recording may end at the fault, if it says so."""
    uncounted: int = 0
    """So many edges may be uncounted: a process that dies between an edge and its counter."""
    hold_s: float = 0.3
    """How long the cause stays, when the robot must go on."""
