"""What may differ on an axis that follows commands: odds, spreads and bounds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from diagnosis.observations.readings import FloatArray
from diagnosis.plants.lone.recorded_axis import LAG_SPREAD_S, LONGEST_LAG_S, RecordedAxis
from diagnosis.plants.regression import Equivalent, Regressor, Size, Sizes
from models.robot import StepperAxis

MOST_BEGINS = 4
"""Stretches whose side of the play at the start is fitted; later ones begin in its middle."""
COARSEST_STEPS = 4.0
"""Steps of the reading in the shortest wave: rounding itself repeats with every step."""
MOST_WAVES = 60.0
FEWEST_WAVES = 2.0
WIDEST_PLAY = 0.6
SLIP_LOG_ODDS = -6.0
"""Of a slip of an axis that counts no steps: as of lost steps, at one moment of all there were."""
OF_REVERSALS = ("friction", "rubbing", "play")
"""Regressors that show where the command turns back; on a one-way travel they are a constant."""
OF_MOVES = ("lag", "ringing")
"""Regressors that are over before the next row where rows are read long after each move."""
OF_TURNS = ("lag", "ringing", "friction", "rubbing", "play")
"""Regressors that show where the speed changes; of an axis at one speed they would fit how the
recording begins."""


def begins_of(axis: RecordedAxis) -> list[str]:
    """Sizes that say where in the play the first stretches begin."""
    count = min(int(np.count_nonzero(axis.readings.fresh)), MOST_BEGINS)
    return ["start", *(f"start_{n}" for n in range(2, count + 1))]


def regressors_of(axis: RecordedAxis) -> list[Regressor]:
    """Every named effect that this recording can tell anything of."""
    lag = (
        Size("time", "half", LAG_SPREAD_S, 0.0, LONGEST_LAG_S, 1e-3),
        Size("dead_time", "half", LAG_SPREAD_S, 0.0, LONGEST_LAG_S, 1e-3),
    )
    width = Size("width", "half", max(2.0 * axis.mismatch, 0.02 * axis.span),
                 0.0, WIDEST_PLAY * axis.span, 0.01 * axis.mismatch)  # fmt: skip
    starts = tuple(Size(name, "flat", 1.0, -1.0, 1.0, 0.05) for name in begins_of(axis))
    late = (
        Equivalent("sensor_latency", -1.0, only_if_zero="time"),
        Equivalent("viscous_friction", -1.5, only_if_zero="dead_time"),
    )
    known_pull = bool(np.ptp(axis.pull[axis.rows]) > 0.0)
    stepper = isinstance(axis.robot, StepperAxis)
    found = [
        Regressor("ratio", "gear_ratio", -2.0 if stepper else -3.0),
        Regressor("lag", "following_lag", -1.0, sizes=lag, equivalents=late),
    ]
    if axis.robot.zero == "absolute":
        found.append(Regressor("offset", "home_offset", -1.0))
    if known_pull:
        found += [
            Regressor("droop", "joint_compliance", -1.0),
            Regressor("play", "gear_backlash", -1.0, sizes=(width, *starts)),
            Regressor("friction", "joint_friction", -1.0, sizes=(width, *starts), saturated=False),
            Regressor(
                "rubbing",
                "joint_friction",
                -1.0,
                sizes=(width, _grip(axis, width), *starts),
                beside=("droop",),
                alone=False,
            ),
        ]
    else:
        # Tooth play is what a geared stepper has, stiction what a servo's loop leaves.
        names = ("gear_backlash", "joint_friction")
        first, second = names if stepper else names[::-1]
        equivalent = Equivalent(second, -1.4 if stepper else -0.2)
        found.append(
            Regressor("play", first, -1.0, sizes=(width, *starts), equivalents=(equivalent,))
        )
    places = (_gear(axis), _jump(axis), _ringing(axis))
    found += [one for one in places if one is not None]
    found.append(Regressor("drift", "unknown", -4.0, follows=("time",), alone=False))
    blind = set(OF_TURNS) if axis.steady else set()
    if not axis.turns_back:
        blind |= set(OF_REVERSALS)
    if axis.arrived:
        blind |= set(OF_MOVES)
    return [one for one in found if one.key not in blind]


def _grip(axis: RecordedAxis, width: Size) -> Size:
    """How much wider friction holds per unit of load: bearings and teeth rub by what they carry
    (Duclusaud et al. 2024, Extended Friction Models for the Physics Simulation of Servo Actuators).
    It shows by the spring that it winds up, so it stands beside one.
    """
    per_load = 1.0 / max(usual_load(axis), 1e-300)
    return Size("grip", "half", width.spread * per_load, 0.0, width.high * per_load,
                width.step * per_load)  # fmt: skip


def usual_load(axis: RecordedAxis) -> float:
    """Mean size of the known load."""
    return float(np.mean(np.abs(axis.pull[axis.rows])))


def _cannot_rub(keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]) -> bool:
    """Friction twice, or of more than the load that makes it (it winds the spring up both ways)."""
    if "rubbing" not in keys:
        return False
    yields = float(linear["droop"][0]) if "droop" in keys else 0.0
    return "friction" in keys or sizes["rubbing.grip"] > 2.0 * yields


def _gear(axis: RecordedAxis) -> Regressor | None:
    waves = Size("waves", "flat", MOST_WAVES, FEWEST_WAVES, most_waves(axis), 0.01)
    if most_waves(axis) <= 2.0 * FEWEST_WAVES:
        return None
    return Regressor(
        "gear", "transmission_error", -3.0, sizes=(waves,),
        equivalents=(Equivalent("encoder_error", -1.0),), alone=False,
    )  # fmt: skip


def most_waves(axis: RecordedAxis) -> float:
    """Waves over the travel that samples can follow: two a wave, of rows and of places alike.

    Many readings at few places (a table of arrivals) show no wave between them.
    """
    pace = float(np.median(np.abs(np.diff(axis.commanded[axis.rows]))))
    finest = max(2.0 * pace, COARSEST_STEPS * axis.resolution, 1e-300)
    return min(MOST_WAVES, axis.span / finest, 0.5 * axis.places)


def highest_hz(axis: RecordedAxis) -> float:
    """The fastest ringing that the samples of a recording can follow, or an axis has."""
    return min(0.2 / axis.readings.period_s, 25.0)


def _jump(axis: RecordedAxis) -> Regressor:
    """Lost steps of a motor that counts them; of any other axis a slip, which has no name here."""
    choices = max(float(axis.readings.span_s), 4.0)
    moment = Size("moment", "flat", axis.readings.span_s, float(axis.t_s[0]),
                  float(axis.t_s[-1]), 1.0, smooth=False, choices=choices)  # fmt: skip
    if not axis.rad_per_step:
        return Regressor("jump", "unknown", SLIP_LOG_ODDS, sizes=(moment,),
                         follows=("time",), alone=False)  # fmt: skip
    return Regressor("jump", "lost_steps", -6.0, sizes=(moment,), alone=False)  # fmt: skip


def _ringing(axis: RecordedAxis) -> Regressor | None:
    fastest = 0.2 / axis.readings.period_s
    if fastest < 1.0:
        return None
    frequency = Size("frequency", "flat", fastest, 0.4, highest_hz(axis), 0.01)
    damping = Size("damping", "flat", 1.0, 0.01, 0.9, 0.01)
    return Regressor("ringing", "resonance", -4.0, sizes=(frequency, damping),
                     alone=False, saturated=False)  # fmt: skip


def impossible(
    axis: RecordedAxis, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
) -> bool:
    """A spring that pushes, sizes at their bounds, play below a step of the reading."""
    if "droop" in keys and linear["droop"][0] <= 0.0:
        return True
    if _cannot_rub(keys, sizes, linear):
        return True
    for key in keys & {"play", "friction", "rubbing"}:
        width = sizes[f"{key}.width"] + usual_load(axis) * sizes.get(f"{key}.grip", 0.0)
        if not axis.resolution < width < 0.99 * WIDEST_PLAY * axis.span:
            return True
    if "gear" in keys:
        waves = sizes["gear.waves"]
        if not 1.01 * FEWEST_WAVES < waves < 0.99 * most_waves(axis):
            return True
    if "lag" in keys and sizes["lag.time"] + sizes["lag.dead_time"] > 0.95 * LONGEST_LAG_S:
        return True
    if "jump" in keys and abs(float(linear["jump"][0])) < axis.full_step:
        return True
    return "ringing" in keys and not 0.011 < sizes["ringing.damping"] < 0.89
