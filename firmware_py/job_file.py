"""A job: robot, path, timing, inverse kinematics, repeats, and where it is recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from foundation.strict_yaml import Document, StrictModel

Point = tuple[float, float, float]
Size = Annotated[float, Field(gt=0.0, le=2.0)]


class _Curve(StrictModel):
    """What all curves in space share."""

    centre_m: Point
    spacing_m: Annotated[float, Field(gt=0.0, le=0.05)] = 0.0005
    """Distance between targets along the path; each target is one network call."""


class Circle(_Curve):
    """A level circle, `turns` times round; negative turns run clockwise seen from above."""

    shape: Literal["circle"]
    radius_m: Size
    turns: Annotated[float, Field(ge=-1000.0, le=1000.0)] = 1.0


class Heart(_Curve):
    """The level heart x = 16 sin^3 t, y = 13 cos t - 5 cos 2t - 2 cos 3t - cos 4t, by width."""

    shape: Literal["heart"]
    width_m: Size
    turns: Annotated[int, Field(ge=1, le=1000)] = 1


class Spiral(_Curve):
    """A level logarithmic spiral r = a exp(b t) from its inner to its outer radius."""

    shape: Literal["spiral"]
    inner_radius_m: Size
    outer_radius_m: Size
    turns: Annotated[float, Field(gt=0.0, le=1000.0)] = 3.0


class Points(StrictModel):
    """Straight lines between points, with a rest at each."""

    shape: Literal["points"]
    points_m: Annotated[tuple[Point, ...], Field(min_length=1, max_length=10_000)]
    dwell_s: Annotated[float, Field(ge=0.0, le=3600.0)] = 0.0
    spacing_m: Annotated[float, Field(gt=0.0, le=0.05)] = 0.0005


class Joints(StrictModel):
    """Arm angles one after another, straight in joint space, with a rest at each."""

    shape: Literal["joints"]
    angles_deg: Annotated[tuple[Point, ...], Field(min_length=1, max_length=100_000)]
    dwell_s: Annotated[float, Field(ge=0.0, le=3600.0)] = 0.0


class Survey(StrictModel):
    """Random arm angles, as Zhao 2023 section 3 collects its training data."""

    shape: Literal["survey"]
    count: Annotated[int, Field(ge=1, le=1_000_000)]
    angle_deg: tuple[float, float] = (-20.0, 110.0)
    dwell_s: Annotated[float, Field(ge=0.0, le=60.0)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 1


PathSpec = Annotated[
    Circle | Heart | Spiral | Points | Joints | Survey, Field(discriminator="shape")
]


class Together(StrictModel):
    """All motors step together, one tick every T_PWM, as in Zhao 2023."""

    mode: Literal["together"] = "together"
    t_pwm_s: Annotated[
        float, Field(ge=50e-6, le=10.0, description="the pulse process is good for 50 us and up")
    ]


class Accelerated(StrictModel):
    """Every motor keeps its own speed and acceleration limit; the path slows down where it must."""

    mode: Literal["accelerated"]
    speed_mps: Annotated[float, Field(gt=0.0, le=10.0)]
    joint_speed_radps: Annotated[float, Field(gt=0.0)] | None = None
    joint_acceleration_radps2: Annotated[float, Field(gt=0.0)] | None = None
    """Lower than the robot file's limits, or absent for those."""


Timing = Annotated[Together | Accelerated, Field(discriminator="mode")]


class GeometryIk(StrictModel):
    """Closed-form inverse kinematics of the robot file's geometry and known effects."""

    kind: Literal["geometry"]


class NetworkIk(StrictModel):
    """A TFLite network; its file names the robot it was trained for."""

    kind: Literal["network"]
    file: str


class JobFile(StrictModel):
    """One job. Named files are sought beside the job, then in the project."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    robot: str
    path: PathSpec
    timing: Timing
    inverse_kinematics: Annotated[GeometryIk | NetworkIk, Field(discriminator="kind")]
    repeats: Annotated[int, Field(ge=1, le=100_000)] = 1
    record: str | None = None
    """Where the recording goes; absent: `recordings/<name>-<date>.mcap`."""
    on_step_loss: Literal["stop", "warn"] = "stop"


def load_job(path: Path) -> JobFile:
    """Read a job file. Raises MissingFile or ConfigError (one line)."""
    return Document.read(path).check(JobFile)
