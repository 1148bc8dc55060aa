"""Paths as job files have them: shapes in space, points, legs, and poses of the arms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field

from deltactl.firmware_py.paths.legs import MOST_LEGS, AsColumns, Legs, packed
from deltactl.firmware_py.paths.path import MAX_TARGETS, BoolArray
from deltactl.firmware_py.paths.shapes import (
    circle_length_m,
    heart_length_m,
    point_target_count,
    spiral_length_m,
)
from deltactl.firmware_py.paths.way import way_target_count
from deltactl.foundation.strict_yaml import RuledModel, StrictModel, rule
from deltactl.models.robot import FloatArray

FARTHEST_M = 10.0
SPEEDS_MPS = (1e-6, 10.0)
Coordinate = Annotated[
    float, Field(ge=-FARTHEST_M, le=FARTHEST_M, description="a robot arm is under 10 m")
]
MOST_DWELL_S = 3600.0
MANY_TURNS = "a thousand turns are hours; use repeats for more"
Point = tuple[Coordinate, Coordinate, Coordinate]
ArmAngle = Annotated[float, Field(ge=-360.0, le=360.0, description="degrees, within one turn")]
Size = Annotated[float, Field(gt=0.0, le=2.0, description="metres; no arm reaches further")]
Spacing = Annotated[
    float,
    Field(ge=1e-6, le=0.05, description="1 um is below any step; arms leave the curve beyond 5 cm"),
]
Dwell = Annotated[float, Field(ge=0.0, le=MOST_DWELL_S, description="seconds, at most an hour")]


def _not_too_many(targets: float) -> None:
    if targets > MAX_TARGETS:
        raise ValueError(
            f"the path has {targets:,.0f} targets, and {MAX_TARGETS:,} are allowed;"
            " make spacing_m larger, or use repeats"
        )


class _Curve(RuledModel):
    """What all curves in space share. Each target is one call of the inverse kinematics."""

    centre_m: Point
    """Its middle: x, y, z."""
    spacing_m: Spacing = 0.0005
    """Distance between targets along the path (made a little shorter to fit the length)."""


class Circle(_Curve):
    """A level circle, `turns` times round; negative turns run clockwise seen from above."""

    shape: Literal["circle"]
    radius_m: Size
    turns: Annotated[float, Field(ge=-1000.0, le=1000.0, description=MANY_TURNS)] = 1.0

    @rule("turns", "radius_m", "spacing_m")
    def _has_length(self) -> None:
        if abs(self.turns) < 1e-3:
            raise ValueError("turns must not be 0: the circle would have no length")
        _not_too_many(circle_length_m(self.radius_m, self.turns) / self.spacing_m)


class Heart(_Curve):
    """The level heart x = 16 sin^3 t, y = 13 cos t - 5 cos 2t - 2 cos 3t - cos 4t, by width.

    `centre_m` is the middle of its box; it is 0.904 times as high as wide.
    """

    shape: Literal["heart"]
    width_m: Size
    turns: Annotated[int, Field(ge=1, le=1000, description=MANY_TURNS)] = 1

    @rule("width_m", "turns", "spacing_m")
    def _bounded(self) -> None:
        _not_too_many(heart_length_m(self.width_m, self.turns) / self.spacing_m)


class Spiral(_Curve):
    """A level logarithmic spiral r = a exp(b t) from its inner to its outer radius."""

    shape: Literal["spiral"]
    inner_radius_m: Size
    outer_radius_m: Size
    turns: Annotated[float, Field(ge=1e-3, le=1000.0, description=MANY_TURNS)] = 3.0

    @rule("inner_radius_m", "outer_radius_m")
    def _grows(self) -> None:
        if self.outer_radius_m <= self.inner_radius_m:
            raise ValueError("outer_radius_m must be larger than inner_radius_m")

    @rule("inner_radius_m", "outer_radius_m", "turns", "spacing_m")
    def _bounded(self) -> None:
        if self.outer_radius_m <= self.inner_radius_m:
            return
        length_m = spiral_length_m(self.inner_radius_m, self.outer_radius_m, self.turns)
        _not_too_many(length_m / self.spacing_m)


class Points(RuledModel):
    """Straight lines between points, with a rest at each."""

    shape: Literal["points"]
    points_m: Annotated[
        tuple[Point, ...],
        Field(min_length=1, max_length=10_000, description="one job is planned in memory"),
    ]
    dwell_s: Dwell = 0.0
    spacing_m: Spacing = 0.0005

    @rule("points_m", "spacing_m")
    def _bounded(self) -> None:
        _not_too_many(point_target_count(self.points_m, self.spacing_m))


class StraightTo(StrictModel):
    """A straight line from wherever the platform is to `to_m`, at the job's speed at most.

    What `goto`, `jog` and the page do. From home, where the arms may be beyond the robot's
    limits, no straight line leads: the arms take another way then, no faster either.
    """

    shape: Literal["straight"]
    to_m: Point


class WayLeg(StrictModel):
    """One leg: to `to_m`, straight; with `centre_m` on an arc about a vertical axis there; or
    with `spline` on a smooth curve through the ends of all such legs that follow each other."""

    to_m: Point
    speed_mps: (
        Annotated[
            float, Field(ge=SPEEDS_MPS[0], le=SPEEDS_MPS[1], description="m/s; 1 um/s to 10 m/s")
        ]
        | None
    ) = None
    """On this leg; never above the job's."""
    dwell_s: Dwell = 0.0
    """Rest at its end for so long."""
    centre_m: tuple[Coordinate, Coordinate] | None = None
    """x and y of an arc's axis; a change of z makes a helix of it."""
    clockwise: bool = False
    """Direction of an arc, seen from above. From a point to itself it is a whole turn."""
    spline: bool = False
    """Legs with it that follow each other make one spline, which passes each of their ends."""


if TYPE_CHECKING:
    LegsOfAFile = Legs
else:
    LegsOfAFile = Annotated[
        tuple[Annotated[WayLeg, AfterValidator(packed)], ...],
        Field(min_length=1, max_length=MOST_LEGS, description="one job is planned in memory"),
        AsColumns(),
    ]


class Way(RuledModel):
    """Straight legs, arcs and splines, passed without a stop where corners may be cut."""

    shape: Literal["way"]
    start_m: Point | None = None
    """Absent, in a job of steps: where the path before this one ended."""
    legs: LegsOfAFile
    corner_m: Annotated[
        float, Field(ge=0.0, le=0.1, description="metres; more is another path")
    ] = 0.0
    """How far from a corner between two legs the way may stay; 0 stops at each."""
    spacing_m: Spacing = 0.0005

    @rule("start_m", "legs", "spacing_m")
    def _bounded(self) -> None:
        if self.start_m is None:
            return
        start_m = np.array(self.start_m)
        _check_legs(start_m, self.legs)
        _not_too_many(way_target_count(start_m, self.legs, self.spacing_m))


LEAST_RADIUS_M = 1e-6
ROUND_PART = 1e-3
ALWAYS_ROUND_M = 28.3e-6
MOST_ROUND_M = 0.5e-3


def same_radius(first_m: FloatArray, last_m: FloatArray) -> BoolArray:
    """Whether the ends of arcs are as far from their centres as rounded coordinates leave them.

    0.1 % of the radius, and 0.0283 mm for any radius, as LinuxCNC has it (interp_internal.hh); and
    never more than 0.5 mm, as grbl has it (gcode.c).
    """
    part_m = ROUND_PART * np.maximum(first_m, last_m)
    is_round: BoolArray = np.abs(first_m - last_m) <= np.clip(part_m, ALWAYS_ROUND_M, MOST_ROUND_M)
    return is_round


def _check_legs(start_m: FloatArray, legs: Legs) -> None:
    """Raises ValueError naming the first leg that contradicts itself."""
    begins_m = np.concatenate([start_m[None], legs.to_m[:-1]])
    inner_m, outer_m = (
        np.linalg.norm(places[:, :2] - legs.centre_m, axis=1) for places in (begins_m, legs.to_m)
    )
    both = legs.spline & legs.is_arc
    nowhere = legs.spline & (np.linalg.norm(legs.to_m - begins_m, axis=1) < 1e-7)
    round_enough = (np.minimum(inner_m, outer_m) >= LEAST_RADIUS_M) & same_radius(inner_m, outer_m)
    wrong = both | nowhere | (legs.is_arc & ~round_enough)
    if not wrong.any():
        return
    number = int(np.argmax(wrong))
    if both[number]:
        raise ValueError(f"legs.{number}: is either an arc (centre_m) or on a spline, not both")
    if nowhere[number]:
        raise ValueError(f"legs.{number}: a leg on a spline must end elsewhere than it begins")
    raise ValueError(
        f"legs.{number}: centre_m must be equally far from both ends of the arc, and is"
        f" {inner_m[number]:.6g} m and {outer_m[number]:.6g} m from them"
    )


class Joints(StrictModel):
    """Arm angles one after another, straight in joint space, with a rest at each."""

    shape: Literal["joints"]
    angles_deg: Annotated[
        tuple[tuple[ArmAngle, ArmAngle, ArmAngle], ...],
        Field(min_length=1, max_length=100_000, description="one job is planned in memory"),
    ]
    dwell_s: Dwell = 0.0


class Survey(RuledModel):
    """Random arm angles, as Zhao 2023 section 3 collects its training data.

    Triples near singular poses are skipped and drawn again, see firmware_py/paths/survey.py.
    """

    shape: Literal["survey"]
    count: Annotated[int, Field(ge=1, le=MAX_TARGETS, description="one job is planned in memory")]
    angle_deg: tuple[ArmAngle, ArmAngle] = (-20.0, 110.0)
    """Between which angles the arms are."""
    dwell_s: Dwell = 0.0
    seed: Annotated[int, Field(ge=0, le=2**63, description="any whole number of 64 bit")] = 1

    @rule("angle_deg")
    def _ordered(self) -> None:
        if self.angle_deg[0] >= self.angle_deg[1]:
            raise ValueError("angle_deg must be [lowest, highest]")


PathSpec = Annotated[
    Circle | Heart | Spiral | Points | StraightTo | Way | Joints | Survey,
    Field(discriminator="shape"),
]
