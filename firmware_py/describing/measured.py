"""What a recording says of the machine that made it: its gear ratio, zero, inertia and weight."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, NamedTuple

from deltactl.firmware_py.describing.question import UNKNOWN
from deltactl.firmware_py.describing.questions import (
    EFFORT_GAIN,
    GEAR,
    INERTIA,
    MICROSTEPS,
    Answers,
    numbers,
)
from deltactl.foundation.errors import RecordingError

if TYPE_CHECKING:
    from deltactl.models.robot import FloatArray
    from deltactl.recording.tables.flat import FlatRecording

MOVED, GAIN = INERTIA.key, EFFORT_GAIN.key


def measured(kind: str, recording: FlatRecording, known: Answers) -> tuple[Answers, list[str]]:
    """Answers that the recording gives, and a line on each. Raises RecordingError without any.

    stepper_axis: the gear ratio, from steps and angle. servo_axis: whether zeros agree; where an
    effort was recorded and no command, what moves, in the unit of the effort.
    """
    if kind == "stepper_axis" and recording.has("steps_1", "theta_1"):
        return _gear(recording, known)
    if recording.has("command", "position"):
        return _zero(recording)
    if kind == "servo_axis" and recording.has("effort", "position"):
        return _forced(recording, known)
    raise RecordingError(
        f"{recording.source}: nothing of a {kind} can be measured from it; leave --measure out"
    )


def _gear(recording: FlatRecording, known: Answers) -> tuple[Answers, list[str]]:
    import numpy as np  # a robot file that is written from answers needs none

    steps, theta = recording.column("steps_1"), recording.column("theta_1")
    both = np.isfinite(steps) & np.isfinite(theta)
    rad_per_step = float(np.polyfit(steps[both], theta[both], 1)[0])
    (microsteps,) = numbers({MICROSTEPS.key: "1600"} | known, MICROSTEPS.key)
    gear = 2.0 * np.pi / (abs(rad_per_step) * microsteps)
    said = (
        f"gear_ratio {gear:.6g}: {abs(rad_per_step):.4g} rad a step, measured; a diagnosis of this "
        "recording cannot find it wrong any more, so give the gear's own ratio where it is known"
    )
    return {GEAR.key: f"{gear:.6g}", MICROSTEPS.key: f"{microsteps:g}"}, [said]


def _zero(recording: FlatRecording) -> tuple[Answers, list[str]]:
    import numpy as np  # as above

    command, position = recording.column("command"), recording.column("position")
    apart = float(np.nanmedian(position - command))
    width = float(np.nanmax(command) - np.nanmin(command))
    zero = "absolute" if abs(apart) < 0.25 * width else "arbitrary"
    return {"zero": zero}, [f"zero: {zero} (readings are {apart:.3g} from the commands)"]


SMOOTHED, WINDOW = 11, 10
"""Rows over which a speed is fitted, and over which its change is held against the effort."""
FEWEST = 10 * SMOOTHED
"""Rows that are needed."""
NOISE = 0.01
"""Share of noise in changes of speed, at most. By so much the inertia is too small, so that a
weight that is stated has to explain more of the effort than this."""
STILL = 0.02
"""Share of the highest speed below which no direction is known."""
_DOUBLED = tuple(2**n for n in range(12))
SHARE = 0.05
"""Share of the effort's power, at least, that has to go with the acceleration, or with a weight."""


class Moved(NamedTuple):
    """What an effort moves, in its own unit: inertia or mass, and what a weight on an axis that
    turns needs to be held level, with the angle at which it hangs [rad]; no weight: 0.
    """

    inertia: float
    weight: float = 0.0
    hangs_rad: float = 0.0


def moved_by_effort(recording: FlatRecording, turns: bool = True) -> Moved | None:
    """What moves, by the effort that goes with its acceleration; None where no share of it does.

    By momentum: over some rows the effort adds up to inertia times the change of speed, beside
    viscous and dry friction, a constant and, where that explains more than chance (by BIC), a
    weight. No acceleration is needed, which noise would drown.
    """
    import numpy as np  # a robot file that is written from answers needs none

    t_s, position, effort = recording.t_s, recording.column("position"), recording.column("effort")
    known = np.isfinite(position) & np.isfinite(effort)
    rows = np.stack([t_s[known], position[known], effort[known]])
    if rows.shape[1] < FEWEST:
        return None
    gained, pushed, others, weight = _over_rows(_without_noise(rows))
    plain, left = _fit(gained, others, pushed)
    weighed, less = _fit(gained, np.concatenate([others, weight], axis=1), pushed)
    apart = len(pushed) / (SMOOTHED + WINDOW)  # rows nearer than this share their readings
    sure = apart * math.log(left / max(less, 1e-9 * left)) > 2.0 * math.log(apart)
    chosen = weighed if turns and sure else plain
    if not (chosen.inertia > 0.0 and chosen.share > SHARE):
        return None
    if chosen is plain or left - less < NOISE * float(np.mean(pushed**2)):
        return Moved(chosen.inertia)
    sine, cosine = weighed.sizes[-2:]
    return Moved(weighed.inertia, math.hypot(sine, cosine), math.atan2(-cosine, sine))


def _over_rows(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Over WINDOW rows each: the change of speed (n,), the sum of the effort (n,), and the sums
    of speed, direction and a constant (n, 3) and of what a weight needs (n, 2).

    rows: times, positions and efforts (3, m).
    """
    import numpy as np  # as above

    half = SMOOTHED // 2
    speed = np.correlate(rows[1], _slope(rows[0]), mode="valid")
    t_s, position, effort = rows[:, half:-half]
    direction = np.where(np.abs(speed) < STILL * np.max(np.abs(speed)), 0.0, np.sign(speed))
    step_s = np.gradient(t_s)

    def added(*shapes: FloatArray) -> FloatArray:
        sums = np.cumsum(np.stack(shapes, axis=1) * step_s[:, None], axis=0)
        whole: FloatArray = np.concatenate([np.zeros((1, len(shapes))), sums])
        return whole[WINDOW:-1] - whole[: -WINDOW - 1]

    others = added(speed, direction, np.ones(len(t_s)))
    weight = added(np.sin(position), np.cos(position))
    return speed[WINDOW:] - speed[:-WINDOW], added(effort)[:, 0], others, weight


def _without_noise(rows: FloatArray) -> FloatArray:
    """Times, positions and efforts (3, n) as means of so few rows that the noise of the positions,
    a step of an encoder included, is little beside what a change of speed is.
    """
    import numpy as np  # as above

    best, least = rows, math.inf
    for many in itertools.takewhile(lambda n: rows.shape[1] // n >= FEWEST, _DOUBLED):
        whole = rows[:, : rows.shape[1] // many * many]
        t_s, position, effort = whole.reshape(3, -1, many).mean(axis=2)
        slope = _slope(t_s)
        speed = np.correlate(position, slope, mode="valid")
        noise = float(np.var(np.diff(position, 3))) / 20.0 * 2.0 * float(np.sum(slope**2))
        share = noise / max(float(np.var(speed[WINDOW:] - speed[:-WINDOW])), 1e-300)
        if share < least:
            best, least = np.stack([t_s, position, effort]), share
        if share < NOISE:
            break
    return best


def _slope(t_s: FloatArray) -> FloatArray:
    """Weights by which SMOOTHED positions give a speed."""
    import numpy as np  # as above

    half = SMOOTHED // 2
    places = np.arange(-half, half + 1)
    slope: FloatArray = places / np.sum(places**2) / float(np.median(np.diff(t_s)))
    return slope


class _Fit(NamedTuple):
    """An inertia beside other shapes: their sizes, and the share of the effort that is its own."""

    inertia: float
    share: float
    sizes: list[float]


def _fit(gained: FloatArray, others: FloatArray, pushed: FloatArray) -> tuple[_Fit, float]:
    """The fit to an effort (n,) over some rows, and the mean square of what it leaves."""
    import numpy as np  # as above

    def left(values: FloatArray) -> FloatArray:
        rest: FloatArray = values - others @ np.linalg.lstsq(others, values, rcond=None)[0]
        return rest

    pushed_left, gained_left = left(pushed), left(gained)
    moved, pushed_in_all = float(np.sum(gained_left**2)), float(np.sum(pushed_left**2))
    inertia = float(np.sum(pushed_left * gained_left)) / max(moved, 1e-300)
    share = inertia**2 * moved / max(pushed_in_all, 1e-300)
    sizes = np.linalg.lstsq(others, pushed - inertia * gained, rcond=None)[0]
    rest = float(np.mean((pushed_left - inertia * gained_left) ** 2))
    return _Fit(inertia, share, sizes.tolist()), rest


def _forced(recording: FlatRecording, known: Answers) -> tuple[Answers, list[str]]:
    """Inertia and gain of an axis of which the effort was recorded: one gives the other."""
    moved = moved_by_effort(recording, turns=known.get("motion", "rotary") == "rotary")
    if moved is None:
        raise RecordingError(
            f"{recording.source}: its effort does not go with its acceleration, so that what moves"
            " cannot be measured from it; leave --measure out, and give --inertia and --effort-gain"
        )
    gain = None if known.get(GAIN, UNKNOWN) == UNKNOWN else numbers(known, GAIN)[0]
    if MOVED in known:
        gain = numbers(known, MOVED)[0] / moved.inertia
    answers = {
        "recorded": "effort",
        MOVED: f"{moved.inertia * (gain or 1.0):.3g}",
        GAIN: UNKNOWN if gain is None else f"{gain:.3g}",
    }
    weight = ""
    if moved.weight and not {"hanging_nm", "constant_nm"} & known.keys():
        answers["hanging_nm"] = f"{moved.weight * (gain or 1.0):.3g}"
        answers["hanging_deg"] = f"{math.degrees(moved.hangs_rad):.3g}"
        holds, hangs = answers["hanging_nm"], answers["hanging_deg"]
        weight = f", a weight that {holds} holds level and that hangs down at {hangs} degrees"
    said = (
        f"{MOVED} {answers[MOVED]}, {GAIN} {answers[GAIN]}{weight}: as the effort of this"
        " recording goes with its acceleration, so that a diagnosis of it cannot find them wrong"
    )
    if gain is None:
        said += (
            "; every size is then in the unit of the effort. Where one of the two is known, give it"
            " (--inertia, or --effort-gain: N m or N for one unit): the other follows"
        )
    return answers, [said]
