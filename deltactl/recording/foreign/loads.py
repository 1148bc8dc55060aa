"""Whether what is taken for an effort is one: of the drive, from outside, or the very command."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.names import Guess, Hint, may_be_outside, without_unit
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import correlation
from deltactl.recording.foreign.units import LINEAR, ROTARY
from deltactl.recording.reading.columns import FloatArray

OF_THE_DRIVE = (
    "taken for what the drive itself gives; if it pulls at the axis from outside (a weight, a"
    " spring)"
)
OF_A_LOAD = (
    "taken for what pulls at the axis from outside (a weight, a spring), as it is 0 while the"
    " axis moves fastest; if the drive itself gives it"
)
BY_NAME = "by its name"
ASKED = frozenset({"command", "command_1", "steps_1"})
MAY_BE_ASKED = (
    "{}: taken for an effort by its name; it goes where {} goes, over as much, and may be its"
    " command: then read it so with --set {}"
)


def may_be_asked(guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]) -> list[str]:
    """A word of an effort that looks like the command of a position without one.

    u is what a controller gives, in the books the effort and in many a log what was asked for.
    """
    by_name = {guess.name: guess for guess in guesses.values()}
    effort, seen = by_name.get("effort"), by_name.get("position") or by_name.get("theta_1")
    if effort is None or seen is None or effort.why != BY_NAME or ASKED & by_name.keys():
        return []
    if effort.unit not in (None, *ROTARY, *LINEAR):  # a heading in N m says what it is
        return []
    u, y = table[effort.source], table[seen.source]
    wide = float(np.nanmax(u) - np.nanmin(u)), float(np.nanmax(y) - np.nanmin(y))
    if correlation(u, y) < GUESSES.asked_alike or max(wide) > GUESSES.asked_as_far * min(wide):
        return []
    unit = effort.unit or seen.unit or "1"
    read = as_option("command", without_unit(effort.source), unit, None, 0.0)
    return [MAY_BE_ASKED.format(effort.source, seen.source, shlex.quote(read))]


def from_outside(
    guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]
) -> tuple[dict[str, Guess], list[str]]:
    """Guesses in which a torque that no drive gives is a load, and a word of what it was taken for.

    guesses: by column. table: columns, name -> (n,).
    """
    by_name = {guess.name: guess for guess in guesses.values()}
    effort, seen = by_name.get("effort"), by_name.get("position")
    if effort is None or seen is None or "command" not in by_name or "load" in by_name:
        return dict(guesses), []
    if effort.why == "as you say" or not may_be_outside(effort.source):
        return dict(guesses), []
    if not _nothing_in_motion(table[effort.source], table[seen.source]):
        instead = "in place of effort in the command below"
        return dict(guesses), [Hint(OF_THE_DRIVE, "name", effort.source, "load", instead)]
    load = replace(effort, role="load", why="it is 0 while the axis moves fastest")
    instead = "in place of load in the command below"
    hint = Hint(OF_A_LOAD, "name", effort.source, "effort", instead)
    return {**guesses, effort.source: load}, [hint]


def _nothing_in_motion(torque: FloatArray, place: FloatArray) -> bool:
    """Whether a torque (n,) is there at rest, and not where a drive would need it.

    A drive that moves an axis has friction and inertia to overcome.
    """
    speed = np.nan_to_num(np.abs(np.gradient(place)))
    most, top = float(np.nanmax(np.abs(torque))), float(np.quantile(speed, 0.99))
    fast = speed > GUESSES.fast_of_top * top
    nothing = np.nan_to_num(np.abs(torque)) <= GUESSES.no_torque * most
    enough = np.count_nonzero(fast) >= GUESSES.fewest_in_common
    return bool(enough and nothing[fast].all() and np.mean(~nothing) > GUESSES.pulled_at)
