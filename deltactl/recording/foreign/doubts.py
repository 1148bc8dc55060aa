"""What looks like another unit than the one a column was read in: by its size, by the steps of an
encoder, and beside a velocity or position that it goes with.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

import numpy as np

from deltactl.recording.column_measures import spacing
from deltactl.recording.foreign.names import read_name, unit_said, without_unit
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.units import IN_SI, LINEAR, LINEAR_SPEEDS, ROTARY, ROTARY_SPEEDS
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.flat import GAP_PERIODS

TURNS: tuple[tuple[float, str], ...] = ((360.0, "deg"), (2.0 * np.pi, "rad"))
"""One turn in each unit. No power of two brings the one near the other (57.3 is 2^5.84), nor near
the decimal steps of a scale in mm."""
SERVO_STEPS: tuple[tuple[float, int], ...] = ((300.0, 1024),)
"""Degrees, and the steps they are parted into: Dynamixel AX."""


def of_encoder(values: FloatArray) -> tuple[str, str] | None:
    """Unit of readings (n,) that go in steps of an encoder, and words for the step; else None."""
    step = even_step(values)
    if step is None:
        return None
    across = float(np.nanmax(values) - np.nanmin(values)) / step
    least, most = GUESSES.near_unit_step
    near = float(np.clip(GUESSES.slip / across, least, most))
    for degrees, parts in SERVO_STEPS:
        if abs(step * parts / degrees - 1.0) < near:
            return "deg", f"in steps of {degrees:g}/{parts} degrees"
    low, high = GUESSES.encoder_bits
    for turn, unit in TURNS:
        bits = round(float(np.log2(turn / step)))
        if low <= bits <= high and abs(step * 2.0**bits / turn - 1.0) < near:
            said = f"360/{2**bits} degrees" if unit == "deg" else f"2 pi/{2**bits} rad"
            return unit, f"in steps of {said}"
    return None


def even_step(values: FloatArray) -> float | None:
    """The step of readings (n,) at evenly spaced places; None where they do not.

    All of them must; of what the engine takes for the rounding of a reading
    (`observations.readings.step_of`) a few may not.
    """
    known = values[np.isfinite(values)]
    if not len(known) or not np.ptp(known):
        return None
    alike = GUESSES.same_reading * float(np.ptp(known))
    places = np.unique(known)
    places = places[np.diff(places, prepend=-np.inf) > alike]
    if len(places) < GUESSES.places_for_a_step:
        return None
    step = spacing(places)
    steps = np.concatenate([[0.0], np.cumsum(np.round(np.diff(places) / step))])
    left = places - step * steps
    far = float(np.max(np.abs(left - np.mean(left))))
    return step if far < GUESSES.off_place * step else None


TOO_LARGE: tuple[tuple[float, str], ...] = (
    *(
        (
            1.0 / IN_SI[f"{small}/s"],
            f"give its unit: velocity=COLUMN[{small}/s]; or is the position in {large}, and not in"
            f" {small}: position=COLUMN[{large}]?",
        )
        for small, large in (("deg", "rad"), ("mm", "m"))
    ),
    (IN_SI["deg"], "is it the position that is in degrees: position=COLUMN[deg]?"),
    (IN_SI["mm"], "is it the position that is in mm: position=COLUMN[mm]?"),
    (1.0 / IN_SI["rpm"], "give its unit: velocity=COLUMN[rpm]"),
)
"""How many times too large the velocity is, and what is to be written then."""


def slope_ratio(t_s: FloatArray, position: FloatArray, velocity: FloatArray) -> float | None:
    """How many times d(position)/dt the velocity is; None where it is no slope of it.

    All of shape (n,), NaN for empty cells. Moves over some rows are compared with the integral of
    the velocity, so that neither rounding of the position nor uneven times count.
    """
    known = np.isfinite(position) & np.isfinite(velocity) & np.isfinite(t_s)
    t_s, position, velocity = t_s[known], position[known], velocity[known]
    if len(t_s) < GUESSES.fewest_in_common:
        return None
    step = np.diff(t_s)
    longest = GAP_PERIODS * float(np.median(step))
    between = 0.5 * (velocity[1:] + velocity[:-1]) * step
    between[step > longest] = np.nan  # and with it whatever spans the gap
    best, ratio = 0.0, None
    for rows in GUESSES.slope_rows:
        if len(t_s) < GUESSES.fewest_in_common + rows:
            break
        went = position[rows:] - position[:-rows]
        whole = np.convolve(between, np.ones(rows), mode="valid")
        good = np.isfinite(whole)
        if good.sum() < GUESSES.fewest_in_common or not (
            np.std(went[good]) and np.std(whole[good])
        ):
            continue
        alike = float(np.corrcoef(went[good], whole[good])[0, 1])
        if abs(alike) > max(best, GUESSES.alike_slope):
            best = abs(alike)
            ratio = float(np.copysign(np.std(whole[good]) / np.std(went[good]), alike))
    return ratio


TURNS_RAD = 4.0 * np.pi
"""Joints seldom turn further; degrees read as rad always do."""
LONG_STEP_S = 2.0
"""Whole steps of time from here on are more often ms or us."""
RTDE = re.compile(r"(actual|target)_q(_?\d)?$")
"""Joint angles in the logs of Universal Robots, in rad by the guide of their interface (RTDE)."""
RADIANS, DEGREES = {"rad", "rad/s"}, {"deg", "deg/s"}
READ = ("position", "theta")
ANGULAR = ("command", *READ)
MOVES = {*ANGULAR, "velocity"}


def doubt(name: str, column: str, unit: str, values: FloatArray) -> str:
    """A sentence for values (n,) that look like another unit; empty where they look right.

    unit: in which the column was read, 1 where nobody said one.
    """
    known = values[np.isfinite(values)]
    if name == "t" and unit == "1" and len(known) > 1:
        step_s = float(np.median(np.diff(known)))
        if step_s >= LONG_STEP_S and bool((known == np.round(known)).all()):
            return (
                f"t was read in s, in steps of {step_s:g} s; if it is in ms,"
                f" --set {_in_unit('t', column, 'ms')}"
            )
    if name.split("_")[0] in ANGULAR and unit in ("1", "rad") and len(known):
        if (step := _other_steps(name, values, "deg")) is not None:
            return (
                f"{name} was read in rad, and its readings go {step}; if it is in degrees,"
                f" --set {_in_unit(name, column, 'deg')}, and the same for the command"
            )
        farthest = float(np.max(np.abs(known)))
        if farthest > TURNS_RAD * (1.0 if unit == "1" else GUESSES.said_factor):
            read = "rad (or m)" if unit == "1" else f"rad ({turns(farthest)})"
            return (
                f"{name} was read in {read}, up to {farthest:.4g}; if it is in degrees,"
                f" --set {_in_unit(name, column, 'deg')}"
            )
    return ""


def of_radians(
    name: str, column: str, unit: str, values: FloatArray, headings: Collection[str]
) -> str:
    """A sentence for angles (n,) read in degrees in a table of radians; empty where there is none.

    headings: of all the table's columns.
    """
    known = values[np.isfinite(values)]
    if unit != "deg" or name.split("_")[0] not in ANGULAR or not len(known):
        return ""
    if (step := _other_steps(name, values, "rad")) is not None:
        return (
            f"{name} was read in degrees, and its readings go {step}; if it is in rad,"
            f" --set {_in_unit(name, column, 'rad')}, and the same for the command"
        )
    farthest = float(np.max(np.abs(known)))
    if unit_said(column, name) is not None or farthest > TURNS_RAD:
        return ""
    if RTDE.match(column):
        why = "logs of RTDE are in rad"
    elif others := [
        heading for heading in headings if _units(heading) & RADIANS and heading != column
    ]:
        why = f"the heading '{others[0]}' says rad"
    elif np.ptp(known) > GUESSES.narrowest_deg:
        return ""
    else:
        why = "few machines move so little"
    return (
        f"{name} was read in degrees and stays within {farthest:.3g}, and {why}; if it is in rad,"
        f" --set {_in_unit(name, column, 'rad')}"
    )


def _in_unit(name: str, column: str, unit: str) -> str:
    """What `--set` takes, in quotes; where the heading says another unit, only a factor wins."""
    contradicts = unit_said(column, name) not in (None, unit)
    return f'"{name}={without_unit(column)}[{unit}]{"*1" if contradicts else ""}"'


def _other_steps(name: str, values: FloatArray, other: str) -> str | None:
    """The steps of an encoder's readings (n,), where they are those of the other unit."""
    if name.split("_")[0] not in READ:
        return None
    unit, step = of_encoder(values) or ("", "")
    return step if unit == other else None


def of_degrees(
    name: str, column: str, unit: str, values: FloatArray, headings: Collection[str]
) -> str:
    """A sentence for angles (n,) read in rad in a table of degrees; empty where there is none.

    headings: of all the table's columns.
    """
    known = values[np.isfinite(values)]
    if unit not in ("1", "rad") or name.split("_")[0] not in ANGULAR or not len(known):
        return ""
    others = [heading for heading in headings if _says_degrees(heading) and heading != column]
    if not others or unit_said(column, name) is not None:
        return ""
    if np.ptp(known) < GUESSES.narrowest_deg:  # few machines move so little in degrees
        return ""
    read = "rad (or m)" if unit == "1" else "rad"
    return (
        f"{name} was read in {read}, and the heading '{others[0]}' says deg; if it is in degrees,"
        f" --set {_in_unit(name, column, 'deg')}"
    )


def _says_degrees(heading: str) -> bool:
    """Whether a heading is that of a motion in degrees; temp_deg is none."""
    return read_name(heading).role in MOVES and _units(heading) & DEGREES != set()


def _units(heading: str) -> set[str | None]:
    """What a heading would say as that of an angle, and as that of a velocity."""
    return {unit_said(heading, "position"), unit_said(heading, "velocity")}


def turns(angle_rad: float) -> str:
    """An angle [rad] as turns."""
    return f"{angle_rad / (2.0 * np.pi):.3g} turns"


def counts_like(values: FloatArray) -> bool:
    """Whether values (n,) are whole numbers beyond a turn of degrees, as an encoder counts."""
    known = np.abs(values[np.isfinite(values)])
    return whole(values) and bool(np.max(known) > GUESSES.least_counts)


def whole(values: FloatArray) -> bool:
    """Whether there are values (n,), and all that are known are whole numbers."""
    known = values[np.isfinite(values)]
    return bool(len(known)) and bool((known == np.round(known)).all())


def of_counts(name: str, column: str, unit: str, values: FloatArray) -> str:
    """Why readings (n,) given in degrees are refused as counts; empty where they are none.

    Commands may be whole degrees over many turns, readings of an angle hardly ever are.
    """
    said = unit_said(column, name) == "deg"
    if unit != "deg" or said or name.split("_")[0] not in READ or not counts_like(values):
        return ""
    return (
        f"{name} is given in degrees, and '{column}' has only whole numbers, up to"
        f" {np.nanmax(np.abs(values)):g}: these look like counts of an encoder. If it has 4096 a"
        f' turn, type --set "{name}={column}*{GUESSES.count_rad}" (the rad of one count; the same'
        f' for the command, if that is counted too); if they are degrees, "{name}={column}[deg]*1"'
    )


def far_from_readings(distance_m: float, range_m: FloatArray, column: str | None) -> str:
    """Why one distance for all rows cannot be what a sensor read (n,); empty where it may be.

    column: of the readings.
    """
    read_m = float(np.nanmedian(np.abs(range_m))) if np.isfinite(range_m).any() else 0.0
    larger, smaller = max(distance_m, read_m), min(distance_m, read_m)
    if not 0.0 < smaller * GUESSES.far_from_read < larger:
        return ""
    unit = min(("cm", "mm"), key=lambda one: abs(np.log(smaller / larger / IN_SI[one])))
    said = f"distance={distance_m:g}[{unit}]"
    if read_m > distance_m:
        said = f"range={without_unit(column or 'COLUMN')}[{unit}]"
    return (
        f"distance is {distance_m:g} m, and the readings are about {read_m:.3g} m; is"
        f" {'the distance' if distance_m > read_m else 'the reading'} in {unit}? Then type"
        f' --set "{said}"'
    )


def other_motion(units: Mapping[str, str], motion: str) -> str:
    """Why units cannot be those of an axis that turns (rotary) or slides (linear); empty if right.

    units: of the columns of the contract, as they were said.
    """
    wrong: tuple[str, ...] = (*ROTARY, *ROTARY_SPEEDS)
    does = "slides"
    if motion == "rotary":
        wrong, does = (*LINEAR, *LINEAR_SPEEDS), "turns"
    other = "linear" if motion == "rotary" else "rotary"
    for name, unit in units.items():
        if name.split("_")[0] in MOVES and unit in wrong:
            return (
                f"{name} is in {unit}, and this axis {does} (motion: {motion} in the robot file);"
                f" give its unit, or say motion: {other}"
            )
    return ""
