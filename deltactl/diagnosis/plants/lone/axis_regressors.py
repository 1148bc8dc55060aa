"""What may differ on an axis that follows commands: odds, spreads and bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, LONE
from deltactl.diagnosis.plants.lone.recorded_axis import RecordedAxis
from deltactl.diagnosis.plants.regressor import Equivalent, Regressor, Size, Sizes, instead, named
from deltactl.models.effects import column_of
from deltactl.models.effects.following_lag import STARTS_S
from deltactl.models.robot import ServoAxis, StepperAxis

PLAYS = frozenset(("friction", "rubbing", "play"))
"""Those that begin somewhere in a play, or in the reach of a friction: all of them."""
WAVES = ("slow", "gear", "teeth")
"""Errors that repeat over the travel, by how often."""
RATIO = "ratio.scale"
OF_MOVES = ("lag", "speed", "ringing")
"""Regressors that are over before the next row where rows are read long after each move."""
LOAD_UNKNOWN = "the load on the axis is not known: it needs {}a column `load`"
GRAVITY_OR = "`gravity` in the robot file, or "
NOTHING_PULLS = "nothing pulls at the axis, as the robot file says"
PULLS_ALIKE = "what pulls at the axis is the same everywhere: what yields then is a constant"


def begins_of(axis: RecordedAxis) -> list[str]:
    """Sizes that say where in the play the first stretches begin."""
    count = min(int(np.count_nonzero(axis.readings.fresh)), COMMANDED_AXIS.most_begins)
    return ["start", *(f"start_{n}" for n in range(2, count + 1))]


def regressors_of(axis: RecordedAxis) -> list[Regressor]:
    """Every named effect that this recording can tell anything of."""
    longest = Size("time", "half", LONE.lag_spread_s, 0.0, LONE.longest_lag_s, 1e-3)
    lag = {"sizes": (longest, replace(longest, name="dead_time")), "starts": STARTS_S}
    found = [
        named(f"{_drive(axis)}/ratio", equivalents=_of_ratio(axis), apart_from=("offset",)),
        named("command/lag", equivalents=instead("command/lag"), **lag),
    ]
    if axis.robot.zero == "absolute":
        zero = column_of("command/offset")[0]
        of_home = instead("loaded/offset", zero) if _may_yield(axis) else ()
        found.append(named("command/offset", equivalents=of_home))
    found += _hysteresis(axis)
    places = (_fastest(axis), *(_waves(axis, key) for key in WAVES), _jump(axis), _ringing(axis))
    found += [one for one in places if one is not None]
    found.append(named("command/drift", follows=("time",), alone=False))
    same = _constants(axis)
    blind = {*(OF_MOVES if axis.arrived else ()), *(same if axis.robot.zero != "absolute" else ())}
    return [
        replace(one, constant=True, saturated=False) if one.key in same else one
        for one in found
        if one.key not in blind
    ]


def _drive(axis: RecordedAxis) -> str:
    return "stepper" if isinstance(axis.robot, StepperAxis) else "servo"


def _is_rotary_servo(axis: RecordedAxis) -> bool:
    return isinstance(axis.robot, ServoAxis) and axis.robot.motion == "rotary"


def _known_pull(axis: RecordedAxis) -> bool:
    return bool(np.ptp(axis.pull[axis.rows]) > 0.0)


def _may_yield(axis: RecordedAxis) -> bool:
    """A weight that the file leaves out bends a rotary servo by nearly the same everywhere, or
    nearly in proportion to its angle; slides are mostly level.
    """
    return _is_rotary_servo(axis) and not _known_pull(axis) and not is_said_to_be_free(axis)


def _of_ratio(axis: RecordedAxis) -> tuple[Equivalent, ...]:
    """What a ratio may be instead; a rotary servo reads the encoder that closes its loop."""
    may_be = {
        "steady/ratio": axis.steady,
        "loaded/ratio": _may_yield(axis),
        "linear/ratio": not _is_rotary_servo(axis),
    }
    ratio = column_of(f"{_drive(axis)}/ratio")[0]
    return tuple(one for place, may in may_be.items() if may for one in instead(place, ratio))


def _hysteresis(axis: RecordedAxis) -> list[Regressor]:
    """What holds the two directions apart, and what yields, where a load is known."""
    width = _play(axis)
    starts = tuple(Size(name, "flat", 1.0, -1.0, 1.0, 0.05) for name in begins_of(axis))
    share = Size("build_up", "half", COMMANDED_AXIS.build_up, 0.0, 1.0, 0.01)
    if not _known_pull(axis):
        either = instead(f"{_drive(axis)}/play")
        sizes = (width, *([] if _drive(axis) == "stepper" else [share]), *starts)
        return [named(f"{_drive(axis)}/play", sizes=sizes, equivalents=either)]
    rubbing = (width, _grip(axis, width), *starts)
    return [
        named("command/droop", above=0.0),
        named("pulled/play", sizes=(width, *starts)),
        named("pulled/friction", sizes=(width, share, *starts), saturated=False),
        named("pulled/rubbing", sizes=rubbing, beside=("droop",), alone=False),
    ]


def _constants(axis: RecordedAxis) -> set[str]:
    """Regressors that this motion makes a constant: nothing is seen of them beside an arbitrary
    zero, and no more than a home offset does beside an absolute one.
    """
    of_plays = PLAYS if axis.steady or not axis.turns_back else ()
    return {*of_plays, *(OF_MOVES if axis.steady else ())}


def is_said_to_be_free(axis: RecordedAxis) -> bool:
    """Whether the robot file says that nothing pulls at the axis: a gravity of zero."""
    gravity = axis.robot.gravity if isinstance(axis.robot, ServoAxis) else None
    return gravity is not None and not axis.pull.any()


def why_none_yields(axis: RecordedAxis) -> str:
    """Why nothing can be learned about compliance, on an axis with a constant load."""
    if is_said_to_be_free(axis):
        return NOTHING_PULLS
    if axis.pull.any():
        return PULLS_ALIKE
    return LOAD_UNKNOWN.format(GRAVITY_OR if isinstance(axis.robot, ServoAxis) else "")


def _fastest(axis: RecordedAxis) -> Regressor | None:
    """A limit between the speed that the axis reaches and the one commanded."""
    usual, fastest = axis.speeds
    if usual >= fastest:
        return None
    limit = Size("limit", "flat", fastest, usual, fastest, 2e-3 * fastest)
    starts = tuple((usual + x * (fastest - usual),) for x in LONE.limit_starts)
    return named("command/speed", sizes=(limit,), alone=False, starts=starts)


def _play(axis: RecordedAxis) -> Size:
    """How wide play, or friction against a spring, may be."""
    spread = max(LONE.size_of_mismatch * axis.mismatch, COMMANDED_AXIS.play_of_travel * axis.span)
    return Size("width", "half", spread, 0.0, COMMANDED_AXIS.widest_play_share * axis.span,
                0.01 * axis.mismatch)  # fmt: skip


def _grip(axis: RecordedAxis, width: Size) -> Size:
    """How much wider friction holds per unit of load: bearings and teeth rub by what they carry
    (Duclusaud et al. 2024, Extended Friction Models for the Physics Simulation of Servo Actuators).
    It shows by the spring that it winds up, so it is fitted beside one.
    """
    per_load = 1.0 / max(usual_load(axis), 1e-300)
    spread, high, step = (one * per_load for one in (width.spread, width.high, width.step))
    return Size("grip", "half", spread, 0.0, high, step)


def usual_load(axis: RecordedAxis) -> float:
    """Mean size of the known load."""
    return float(np.mean(np.abs(axis.pull[axis.rows])))


def _cannot_rub(keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]) -> bool:
    """Friction twice, or of more than the load that makes it (it winds the spring up both ways)."""
    if "rubbing" not in keys:
        return False
    yields = float(linear["droop"][0]) if "droop" in keys else 0.0
    return "friction" in keys or sizes["rubbing.grip"] > COMMANDED_AXIS.grip_of_yielding * yields


def _waves(axis: RecordedAxis, key: str) -> Regressor | None:
    """Errors of a gear that repeat so often over the travel.

    Slow ones take what is smooth, and fine ones many rows: neither shows what noise is.
    """
    low, high = waves_of(axis, key)
    if high < COMMANDED_AXIS.more_than_waves * low:
        return None
    widest = max(high, COMMANDED_AXIS.most_waves)
    waves = Size("waves", "flat", widest, low, high, 0.01, within=_inside(low, high))
    return named(
        f"command/{key}", sizes=(waves,), equivalents=instead(f"command/{key}"), alone=False,
        mapped=True, saturated=key == "gear", places=high - low, measured_by=RATIO,
    )  # fmt: skip


def waves_of(axis: RecordedAxis, key: str) -> tuple[float, float]:
    """Fewest and most waves over the travel: slow ones, of a wheel or a screw, finer ones; as far
    as the readings can follow.
    """
    ends = [COMMANDED_AXIS.fewest_waves, COMMANDED_AXIS.some_waves, COMMANDED_AXIS.most_waves]
    first = WAVES.index(key)
    low, *more = ends[first : first + 2]
    return low, min([*more, axis.resolved_waves])


def _inside(low: float, high: float) -> tuple[float, float]:
    """Ends within which a size was found, and not its bound."""
    return (1.0 + LONE.near_bound) * low, (1.0 - LONE.near_bound) * high


def _jump(axis: RecordedAxis) -> Regressor:
    """Lost steps of a motor that counts them; of any other axis a slip, which has no name here."""
    choices = max(float(axis.readings.span_s), COMMANDED_AXIS.fewest_moments)
    moment = Size("moment", "flat", axis.readings.span_s, float(axis.t_s[0]),
                  float(axis.t_s[-1]), 1.0, smooth=False, choices=choices)  # fmt: skip
    places = COMMANDED_AXIS.alarming_chi2 * math.log(max(len(axis.rows), 2))
    if not axis.rad_per_step:
        return named("slip/jump", sizes=(moment,), follows=("time",), alone=False, places=places)
    return named("command/jump", sizes=(moment,), alone=False, places=places)


def _ringing(axis: RecordedAxis) -> Regressor | None:
    """From the slowest of which a recording holds some periods, to the fastest that its samples can
    follow, or that an axis has.
    """
    in_it = COMMANDED_AXIS.ringing_periods / max(axis.readings.span_s, 1e-300)
    slowest = max(COMMANDED_AXIS.slowest_ringing_hz, in_it)
    followed_hz = COMMANDED_AXIS.ringing_of_rate / axis.readings.period_s
    fastest = min(followed_hz, COMMANDED_AXIS.fastest_ringing_hz)
    if fastest <= slowest:
        return None
    inside, damped = _inside(slowest, fastest), _inside(*COMMANDED_AXIS.damping)
    frequency = Size("frequency", "flat", fastest, slowest, fastest, 0.01, within=inside)
    damping = Size("damping", "flat", 1.0, *COMMANDED_AXIS.damping, 0.01, within=damped)
    from_hz = COMMANDED_AXIS.ringing_from * slowest
    up_to_hz = COMMANDED_AXIS.ringing_up_to * fastest
    count = 1 + math.ceil(math.log(up_to_hz / from_hz, COMMANDED_AXIS.ringing_apart))
    each = np.geomspace(from_hz, up_to_hz, count)
    starts = tuple((float(hz), COMMANDED_AXIS.damping_start) for hz in each)
    return named(
        "command/ringing", sizes=(frequency, damping), alone=False, saturated=False, starts=starts
    )


def _gap_of_a_lag(axis: RecordedAxis, keys: frozenset[str], sizes: Sizes) -> float:
    """Gap between the directions that a delay leaves which is not quite as its operator has it."""
    if "lag" not in keys:
        return 0.0
    late_s = sizes["lag.time"] + sizes["lag.dead_time"]
    return COMMANDED_AXIS.gap_of_a_lag * 2.0 * late_s * axis.usual_speed


def impossible(
    axis: RecordedAxis, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
) -> bool:
    """Play below a step of the reading, friction without a load, sizes that show in nothing."""
    if _cannot_rub(keys, sizes, linear):
        return True
    near = LONE.near_bound
    widest = (1.0 - near) * COMMANDED_AXIS.widest_play_share * axis.span
    least = max(axis.resolution, _gap_of_a_lag(axis, keys, sizes))
    for key in keys & {"play", "friction", "rubbing"}:
        width = sizes[f"{key}.width"] + usual_load(axis) * sizes.get(f"{key}.grip", 0.0)
        if not least < width < widest:
            return True
    longest_s = COMMANDED_AXIS.together_of_longest * LONE.longest_lag_s
    if "lag" in keys and sizes["lag.time"] + sizes["lag.dead_time"] > longest_s:
        return True
    if "speed" in keys and not least < axis.behind_a_limit(sizes["speed.limit"]):
        return True
    return "jump" in keys and abs(float(linear["jump"][0])) < axis.full_step
