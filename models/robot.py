"""The sections of a robot file that describe the machine itself.

The frame: origin in the plane of the motor axes, z up, arm 1 along +x; an arm angle of
0 is horizontal and positive is down.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag

from deltactl.foundation.strict_yaml import RuledModel, StrictModel, rule
from deltactl.models.servo_drive import ServoDrive

AXES = ("x", "y", "z")
ARMS = 3

Length = Annotated[float, Field(gt=0.0, lt=10.0, description="a robot arm is under 10 m")]
PerArmLength = Length | tuple[Length, Length, Length]
Angle = Annotated[float, Field(ge=-360.0, le=360.0, description="degrees, within one turn")]
Component = Annotated[float, Field(ge=-1.001, le=1.001, description="a direction of length 1")]
Mass = Annotated[float, Field(ge=0.0, lt=1000.0, description="kilograms of a moving part")]
FloatArray = np.ndarray[Any, np.dtype[np.float64]]

MACHINE_SECTIONS = (
    *("steps", "inputs", "outputs", "ranging", "limits", "homing"),
    *("recordings", "networks", "as_built"),
)
"""Sections of a robot file that belong to the machine's wiring, not to its model."""


def per_arm(value: float | tuple[float, float, float]) -> FloatArray:
    """One value for all arms, or one each, as an array of shape (3,)."""
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (ARMS,)).copy()


class Geometry(StrictModel):
    """Lengths and directions of the linkage; a length may be one number or one an arm."""

    base_radius_m: PerArmLength
    """From the middle of the base to the axes of the motors."""
    platform_radius_m: PerArmLength
    """From the middle of the platform to the joints of the forearms."""
    upper_arm_m: PerArmLength
    """From the axis of the motor to the elbow."""
    forearm_m: PerArmLength
    """From the elbow to the platform."""
    azimuth_deg: tuple[Angle, Angle, Angle] = (0.0, 120.0, 240.0)
    """Directions of the arms, counterclockwise from x, seen from above."""
    home_offset_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    """True angle minus commanded angle at count 0 (known and corrected for)."""

    @property
    def radius_m(self) -> FloatArray:
        """Base minus platform radius, the only combination the linkage sees; shape (3,)."""
        return per_arm(self.base_radius_m) - per_arm(self.platform_radius_m)

    @property
    def azimuth_rad(self) -> FloatArray:
        """Direction of each arm about z; shape (3,)."""
        return np.deg2rad(np.asarray(self.azimuth_deg, dtype=np.float64))


class Masses(StrictModel):
    """Moving masses; the forearm is one arm's pair of rods."""

    upper_arm_kg: Mass
    forearm_kg: Mass
    platform_kg: Mass


class Drive(StrictModel):
    """How a stepper's counts become arm angles."""

    kind: Literal["stepper"] = "stepper"
    microsteps_per_rev: Annotated[
        int, Field(ge=1, le=1_000_000, description="drives offer 200 to 51200")
    ]
    """As the drive is set: pulses for one turn of the motor; of an encoder its counts."""
    gear_ratio: Annotated[float, Field(gt=0.0, le=1e6, description="motor turns per arm turn")]

    @property
    def rad_per_step(self) -> float:
        """Arm angle of one microstep [rad]."""
        return 2.0 * np.pi / (self.microsteps_per_rev * self.gear_ratio)


AnyDrive = Drive | ServoDrive
"""Either counts in `rad_per_step`: microsteps, or a servo's set-points."""


def kind(drive: Any) -> Any:
    """The kind that a `drive` section asks for; without one it is a stepper's."""
    if isinstance(drive, dict):
        return drive.get("kind", "stepper")
    return getattr(drive, "kind", "stepper")


DriveSection = Annotated[
    Annotated[Drive, Tag("stepper")] | Annotated[ServoDrive, Tag("servo")], Discriminator(kind)
]


class SensorAxis(RuledModel):
    """A distance sensor reports `offset_m + axis . p` with p the platform position."""

    offset_m: Annotated[float, Field(gt=-10.0, lt=10.0, description="a distance sensor sees 4 m")]
    """What it would read with the platform at the origin."""
    axis: tuple[Component, Component, Component]
    """The direction in which the platform moves when the reading grows."""

    @rule("axis")
    def _unit_length(self) -> None:
        if abs(float(np.linalg.norm(self.axis)) - 1.0) > 1e-3:
            raise ValueError("axis must be a direction of length 1")


class Sensors(StrictModel):
    """The three distance sensors."""

    x: SensorAxis
    y: SensorAxis
    z: SensorAxis

    @property
    def offsets_m(self) -> FloatArray:
        """Shape (3,)."""
        return np.array([self.x.offset_m, self.y.offset_m, self.z.offset_m])

    @property
    def axes(self) -> FloatArray:
        """Directions as rows; shape (3, 3)."""
        return np.array([self.x.axis, self.y.axis, self.z.axis])


class FoundBy(StrictModel):
    """Where the sizes of an effect come from."""

    recordings: tuple[str, ...]
    """Their files."""
    on: Annotated[str, Field(pattern=r"^\d{4}-\d{2}-\d{2}$", description="a day, as 2026-01-31")]
    """The day on which they were worked out."""
    ci95: dict[str, tuple[float, float] | tuple[tuple[float, float], ...]] = Field(
        default_factory=dict
    )
    """Interval of each parameter that was fitted; of a vector one a component."""
    spread: dict[str, tuple[float, ...]] = Field(default_factory=dict)
    """Its standard deviation in parts that move together."""
    probability: Annotated[float, Field(ge=0.0, le=1.0, description="a probability")] | None = None
    """That this effect acts at this component; absent where it was not worked out."""
    loosely_built: bool = False
    """Small errors of building were allowed for beside it, and are again in the next diagnosis."""


class EffectEntry(StrictModel):
    """One effect of the vocabulary with its parameters in SI units."""

    effect: str
    """Its name in docs/reference/effects.md."""
    component: str
    """The part that has it."""
    parameters: dict[str, float | tuple[float, ...]] = Field(default_factory=dict)
    """Its sizes, by name."""
    found: FoundBy | None = None
    """None where somebody wrote the entry by hand."""


class DeltaRobot(StrictModel):
    """The accepted model of a rotary delta; `effects` are known and part of it."""

    kind: Literal["delta"]
    name: Annotated[str, Field(min_length=1, max_length=100)]
    """What reports and recordings call it."""
    geometry: Geometry
    masses: Masses | None = None
    drive: DriveSection | None = None
    """Steppers, or servo drives that are commanded a current."""
    sensors: Sensors | None = None
    effects: tuple[EffectEntry, ...] = ()
    """What is known to be otherwise than in the sections above, and is corrected for."""
    calibrated_from: Annotated[str, Field(pattern="^([0-9a-f]{16})?$")] = ""
    """In a calibrated robot: fingerprint of the geometry it was designed with. Networks that
    learned that robot's samples are of this one: it is the same machine, better described."""
    calibrated_on: str = ""
    """The machine whose samples it was calibrated on, in the words of the data set."""


class StepperAxis(StrictModel):
    """One stepper motor and its gear, no linkage."""

    kind: Literal["stepper_axis"]
    name: str
    """What reports call it."""
    drive: Drive | None = None
    """Not needed where recordings give angles."""
    zero: Literal["arbitrary", "absolute"] = "absolute"
    """`arbitrary`: a constant between command and reading means nothing; `absolute` also where one
    was set equal to the other once."""
    effects: tuple[EffectEntry, ...] = ()
    """What is known of it already."""


class AxisGravity(StrictModel):
    """What holds the weight on an axis = force_n, or constant_nm + torque_nm * sin(position -
    zero_rad)."""

    torque_nm: Annotated[
        float, Field(ge=-1e6, le=1e6, description="no motor holds a hundred tonnes on a metre")
    ] = 0.0
    """What holds the weight of a turning axis level."""
    zero_rad: float = 0.0
    """Where that weight hangs straight down; the same any number of turns further."""
    constant_nm: Annotated[
        float, Field(ge=-1e6, le=1e6, description="no drum of a metre holds a hundred tonnes")
    ] = 0.0
    """What holds a load that is the same at every angle: a weight on a rope over a drum."""
    force_n: Annotated[
        float, Field(ge=-1e6, le=1e6, description="no slide holds a hundred tonnes")
    ] = 0.0
    """What holds a slide on a slope, anywhere on it."""


class ServoAxis(RuledModel):
    """Effort in, position out (or command in, position out)."""

    kind: Literal["servo_axis"]
    name: str
    """What reports call it."""
    motion: Literal["linear", "rotary"]
    """Whether it slides or turns; m, N and kg, or rad, N m and kg m2."""
    inertia: Annotated[float, Field(gt=0.0, description="something moves")] | None = None
    """Inertia of all that moves; needed only where there is an effort column."""
    effort_gain: (
        Annotated[float, Field(gt=0.0, description="turn the sign of the effort column instead")]
        | Literal["unknown"]
    ) = 1.0
    """Torque or force for one unit of the effort column; `unknown`: forces are in its unit."""
    gravity: AxisGravity | None = None
    drive_stiffness: (
        Annotated[float, Field(gt=0.0, description="with 0 nothing would hold it")] | None
    ) = None
    """By which the position drive yields to a load; absent where it is not known."""
    zero: Literal["arbitrary", "absolute"] = "absolute"
    """`arbitrary`: a constant between command and reading means nothing; `absolute` also where one
    was set equal to the other once."""
    effects: tuple[EffectEntry, ...] = ()
    """What is known of it already."""

    @property
    def force_per_effort(self) -> float:
        """Torque or force for one unit of the effort column, 1 where it is not known."""
        return 1.0 if self.effort_gain == "unknown" else self.effort_gain

    @rule("motion", "gravity")
    def _slides(self) -> None:
        if self.gravity is None:
            return
        if self.motion == "rotary" and self.gravity.force_n != 0.0:
            raise ValueError(
                "gravity.force_n is for a slide; for an axis that turns, enter torque_nm or"
                " constant_nm"
            )
        if self.motion == "linear" and self.gravity.constant_nm != 0.0:
            raise ValueError(
                "gravity.constant_nm is for an axis that turns; for a slide, enter force_n"
            )


class RangeSensor(StrictModel):
    """A range sensor alone: true distance in, range out."""

    kind: Literal["range_sensor"]
    name: str
    """What reports call it."""
    effects: tuple[EffectEntry, ...] = ()
    """What is known of it already."""


Positive = Annotated[float, Field(gt=0.0, description="turn the sign of the column instead")]


Count = Annotated[int, Field(ge=-(2**31), le=2**31, description="encoders have 32 bits")]
Metres = Annotated[float, Field(ge=-100.0, le=100.0, description="m, within a workshop")]


class Target(StrictModel):
    """A reflector or marker on a chain."""

    link: str
    """That carries it."""
    xyz: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    """In the link's frame."""


OF_EACH_JOINT = ("effort_gain", "gear", "drive", "zero_count")
"""Keys whose values are one for all joints, or one a joint."""


class ChainRobot(RuledModel):
    """An arm or gantry that a URDF or MJCF describes."""

    kind: Literal["chain"]
    name: Annotated[str, Field(min_length=1, max_length=100)]
    """What reports call it."""
    model: Annotated[str, Field(description="a URDF (.urdf) or MJCF (.xml)")]
    """Beside the robot file."""
    joints: Annotated[
        tuple[Annotated[str, Field(min_length=1)], ...],
        Field(min_length=1, max_length=32, description="joints of one chain"),
    ]
    """In the order of the columns."""
    effort_gain: Positive | tuple[Positive, ...] | Literal["unknown"] = 1.0
    """At the joint for one unit of effort; `unknown`: measured by the model."""
    gear: Positive | tuple[Positive, ...] = 1.0
    """Motor turns per joint turn."""
    drive: Drive | tuple[Drive | None, ...] | None = None
    """Makes angles of the counts in `theta`, `command` and `velocity`; null: these are angles."""
    zero_count: Count | tuple[Count, ...] = 0
    """Count at the zero of the model."""
    gravity: bool = True
    """Whether efforts hold weights."""
    zero: Literal["absolute", "arbitrary"] = "absolute"
    """arbitrary: zeros of joints are no findings."""
    placement: Literal["arbitrary", "known"] = "arbitrary"
    """known: base and targets are looked for near these."""
    base: dict[Literal["xyz", "rpy"], tuple[Metres, Metres, Metres]] = Field(default_factory=dict)
    """In the frame of measured poses, in m; in rad about x, y, z."""
    targets: dict[str, Target] = Field(default_factory=dict)
    """By the stem of their columns: pos, pos1, pos2."""
    effects: tuple[EffectEntry, ...] = ()
    """What is known of it already."""

    @rule("joints")
    def _named_once(self) -> None:
        if twice := [name for name in self.joints if self.joints.count(name) > 1]:
            raise ValueError(f"joints has '{twice[0]}' twice")

    @rule("joints", *OF_EACH_JOINT)
    def _one_a_joint(self) -> None:
        for key in OF_EACH_JOINT:
            value = getattr(self, key)
            if isinstance(value, tuple) and len(value) != len(self.joints):
                raise ValueError(
                    f"{key} has {len(value)} entries and joints {len(self.joints)} names;"
                    " it is one for all, or one a joint"
                )

    @property
    def effort_per_unit(self) -> FloatArray:
        """What one unit of the effort column makes at each joint, (joints,) [N m or N].

        Without the gain, where that is not known.
        """
        gain = 1.0 if self.effort_gain == "unknown" else np.asarray(self.effort_gain)
        made: FloatArray = np.ones(len(self.joints)) * gain * self.gear
        return made

    @property
    def rad_per_count(self) -> tuple[float | None, ...]:
        """What one count of a joint's columns turns it by; None where these are angles."""
        own = self.drive if isinstance(self.drive, tuple) else (self.drive,) * len(self.joints)
        return tuple(None if one is None else one.rad_per_step for one in own)

    @property
    def zero_counts(self) -> tuple[int, ...]:
        """Count of each joint at the zero of its model."""
        given = self.zero_count
        return given if isinstance(given, tuple) else (given,) * len(self.joints)

    def with_gains(self, gains: FloatArray) -> ChainRobot:
        """The same with other gains of its joints, (joints,)."""
        return self.model_copy(update={"effort_gain": (*map(float, gains),)})


RobotModel = DeltaRobot | StepperAxis | ServoAxis | RangeSensor | ChainRobot
AnyKind = type[DeltaRobot | StepperAxis | ServoAxis | RangeSensor | ChainRobot]

KINDS: dict[str, AnyKind] = {
    "delta": DeltaRobot,
    "stepper_axis": StepperAxis,
    "servo_axis": ServoAxis,
    "range_sensor": RangeSensor,
    "chain": ChainRobot,
}
