"""The whole robot file: model, wiring, limits and, for simulation, how it was really built."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from deltactl.drivers.settings import (
    InputSettings,
    Name,
    Pin,
    RangingSettings,
    StepSettings,
    SwitchedPin,
)
from deltactl.drivers.steps.lines import MOST_SWITCHES, Switches
from deltactl.firmware_py.pins_named import named_twice, pins_named
from deltactl.firmware_py.servo.as_built import AsBuiltServo
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.explain import Mistake
from deltactl.foundation.strict_yaml import Document, RuledModel, StrictModel, rule, valid_keys_of
from deltactl.models.gearing import LEAST_RATIO, too_small_ratio
from deltactl.models.robot import (
    KINDS,
    AnyDrive,
    DeltaRobot,
    DriveSection,
    EffectEntry,
    Masses,
)
from deltactl.models.robot_files import of_delta, wrong_effects, wrong_entries, wrong_values
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.writing.retention import KeptRecordings

Angle = Annotated[float, Field(ge=-360.0, le=360.0, description="degrees, within one turn")]
JointSpeed = Annotated[
    float, Field(gt=0.0, le=1000.0, description="160 turns a second are too many")
]
Disagreement = Annotated[float, Field(gt=0.0, description="sensors never agree to nothing")]
Coordinate = Annotated[float, Field(gt=-10.0, lt=10.0, description="a robot arm is under 10 m")]

SAID_FOR_HARDWARE: dict[str, tuple[str, ...]] = {
    "steps": ("step_pins", "direction_pins", "enable_pin", "alarm_pins"),
    "inputs": ("estop_pin",),
    "ranging": ("xshut_pins",),
    "limits": (
        *("arm_deg", "step_rate_hz", "joint_speed_radps", "joint_acceleration_radps2"),
        "approach_speed_radps",
    ),
    "homing": ("method", "angle_deg"),
}
"""Keys without which a robot runs simulated only; `null` says that there is no such pin."""
I2C_PINS = (2, 3)
"""SDA and SCL of bus 1 on the 40-pin header."""


class Limits(RuledModel):
    """What no motion may exceed; checked along the whole path before anything moves."""

    arm_deg: tuple[Angle, Angle] = (-20.0, 110.0)
    """Lowest and highest commanded arm angle (rounding to a whole step may add half a step)."""
    box_m: (
        tuple[
            tuple[Coordinate, Coordinate],
            tuple[Coordinate, Coordinate],
            tuple[Coordinate, Coordinate],
        ]
        | None
    ) = None
    """Cartesian box (x, y, z), each (low, high); the way from home into it is allowed."""
    step_rate_hz: Annotated[
        float, Field(gt=0.0, le=500_000.0, description="CL57T takes 500 kHz")
    ] = 20_000.0
    """The pulse process on a Pi is good for about 10 to 20 kHz."""
    joint_speed_radps: JointSpeed = 8.0
    """The default is what 20 kHz gives on the Zhao drive (750 rev/min of the motor)."""
    joint_acceleration_radps2: Annotated[
        float, Field(gt=0.0, le=1e5, description="rad/s2; beyond is a blow")
    ] = 20.0
    """In accelerated motion; stepping together (Zhao 2023) has no ramps to limit."""
    approach_speed_radps: JointSpeed = 0.5
    """Joint speed of the move to where a path starts."""
    singularity_margin: Annotated[float, Field(ge=0.0, lt=1.0, description="a sine")] = 0.05
    """How near to singular a motion may come: smallest sine between a forearm and the plane of
    its upper arm, and smallest volume spanned by the three forearm directions."""
    network_deg: Annotated[
        float, Field(gt=0.0, le=180.0, description="0 refuses every network, 180 none")
    ] = 10.0
    """How far a network's arm angles may lie from the geometry's before it counts as broken:
    well above play, home offsets and length errors, well below a collision."""

    @rule("arm_deg")
    def _arms_in_order(self) -> None:
        if self.arm_deg[0] >= self.arm_deg[1]:
            raise ValueError("arm_deg must be [lowest, highest]")

    @rule("box_m")
    def _box_in_order(self) -> None:
        for low, high in self.box_m or ():
            if low >= high:
                raise ValueError("box_m must be three pairs of [lowest, highest]")


class Homing(RuledModel):
    """How the robot learns where its arms are: put against their stops, or by a switch an arm."""

    method: Literal["placed", "switch"] = "placed"
    """`placed`: somebody puts the arms against their stops; `switch`: each arm seeks its switch."""
    angle_deg: tuple[Angle, Angle, Angle] = (30.0, 30.0, 30.0)
    """Angles of the arms at their stops or switches."""
    switch_pins: tuple[Pin, Pin, Pin] | None = None
    """Pins of arms 1, 2, 3; needed with `method: switch`."""
    switch_active_high: bool = False
    """Level of a pin while its switch is pressed."""
    speed_radps: Annotated[
        float, Field(gt=0.0, le=1.0, description="a switch is met at walking pace")
    ] = 0.1
    switch_tolerance_deg: Annotated[
        float,
        Field(
            ge=0.005,
            le=1.0,
            description="a good switch repeats to hundredths of a degree; one that repeats to no"
            " better than a degree is no reference",
        ),
    ] = 0.1
    """How far apart an arm may meet its switch in two approaches."""
    search_deg: (
        Annotated[float, Field(gt=0.0, le=360.0, description="degrees, within one turn")] | None
    ) = None
    """How far below its switch an arm may hang when it is homed. It bounds how far an arm rises
    where the sensors do not see it; by default the way from `angle_deg` to the lower limit."""
    tolerance_m: Disagreement = 0.03
    """How far the sensors may disagree with the home angles before homing is refused. At rest and
    at the end of a job: how far ranges and counts may part from what they were at homing."""
    warning_m: Disagreement = 0.01
    """From this disagreement on, homing asks to look again where the arms were placed. An arm
    that rises to its switch stops where the sensors see it past home by more than this explains,
    and a robot at rest whose ranges drift further apart from its counts is no longer homed."""

    @rule("method", "switch_pins")
    def _has_switches(self) -> None:
        if self.method == "switch" and self.switch_pins is None:
            raise ValueError("method 'switch' needs switch_pins")


class SensorNoise(StrictModel):
    """Noise of a simulated distance sensor."""

    sigma_m: Annotated[
        float, Field(ge=0.0, le=0.1, description="metres; a VL53L1X has 1 to 5 mm")
    ] = 0.0015
    correlation: Annotated[float, Field(ge=0.0, lt=1.0, description="1 is no noise")] = 0.0
    seed: Annotated[int, Field(ge=0, description="any whole number")] | None = None
    """The same seed is the same noise in every run; null takes one of the robot's name."""


class AsBuilt(StrictModel):
    """What the simulated robot is really like; the controller never reads this."""

    effects: tuple[EffectEntry, ...] | None = None
    """All the true effects; the file's own `effects` are the accepted model.
    None: the simulated robot equals the accepted model."""
    noise: SensorNoise = SensorNoise()
    servo: AsBuiltServo | None = None
    """Only with drive.kind servo."""
    inputs: dict[Name, bool] = Field(default_factory=dict)
    """Which of `inputs.named` are on, while simulated; the others are off."""


class RobotFile(DeltaRobot):
    """A delta robot with its wiring and limits."""

    drive: DriveSection
    """Steppers, or servo drives that are commanded a current."""
    steps: StepSettings = StepSettings()
    inputs: InputSettings = InputSettings()
    outputs: Annotated[
        dict[Name, SwitchedPin], Field(max_length=MOST_SWITCHES, description="a byte of them")
    ] = Field(default_factory=dict)
    """What jobs switch, by name: `gripper: {pin: 12, safe: off}`."""
    ranging: RangingSettings = RangingSettings()
    limits: Limits = Limits()
    homing: Homing = Homing()
    recordings: KeptRecordings = KeptRecordings()
    networks: Annotated[
        dict[str, str], Field(max_length=1000, description="one for each network there is")
    ] = Field(default_factory=dict)
    """A network that jobs name -> the file to take in its place, trained for this file's effects;
    so that jobs need not be edited when a robot is corrected."""
    as_built: AsBuilt = AsBuilt()

    @property
    def effects_as_built(self) -> tuple[EffectEntry, ...]:
        """The effects of the simulated robot."""
        built = self.as_built.effects
        return self.effects if built is None else built

    @property
    def tick_s(self) -> float:
        """Shortest time between steps of different motors that are no one tick; 0: any will do."""
        return 0.0 if isinstance(self.drive, ServoDrive) else self.steps.tick_s

    @property
    def switches(self) -> Switches:
        """The outputs as bits."""
        return Switches(self.outputs)

    def is_machine_of(self, other: RobotFile) -> bool:
        """Whether both files are of one machine, with another name or other effects."""
        may_differ = {
            "name": "",
            "effects": (),
            "networks": {},
            "as_built": AsBuilt(),
            "recordings": KeptRecordings(),
        }
        return self.model_copy(update=may_differ) == other.model_copy(update=may_differ)

    def clashes(self) -> Iterator[Mistake]:
        """Where sections contradict each other: the key at fault, and what is wrong with it."""
        yield from _clashes(dict(self))
        yield from named_twice(pins_named(self.model_dump()), _i2c_pins(self.model_dump()))

    def left_open(self) -> list[str]:
        """What must be said before anything moves on hardware, and is not: keys of the file.

        Defaults of these are another robot's; simulated, nothing is hurt by them.
        """
        return [
            f"{section}.{key}"
            for section, keys in SAID_FOR_HARDWARE.items()
            for key in keys
            if not (section == "ranging" and self.sensors is None)
            if key not in getattr(self, section).model_fields_set
        ]


def load_robot(path: Path, follow: bool = True) -> RobotFile:
    """Read a robot file for running. Raises MissingFile or ConfigError (a line for each mistake).

    follow: whether links may lead to it.
    """
    return robot_in(Document.read(path, follow))


def robot_in(document: Document) -> RobotFile:
    """The robot of a file that was read. Raises ConfigError (a line for each mistake)."""
    kind = document.data.get("kind")
    if kind is None and "robot" in document.data:
        named = document.data["robot"]
        raise document.fail(
            ("robot",), f"this is a job, and a robot file is needed here, such as {named}"
        )
    if kind != "delta":
        known = "cannot be run, only diagnosed" if kind in KINDS else "must be 'delta'"
        raise document.fail(("kind",), f"{known} (got {kind!r})")
    try:
        robot = document.check(RobotFile)
    except ConfigError as error:
        others = () if document.is_long else _also_wrong(document.data)
        raise ConfigError(*error.args, *document.fail_all(others).args) from None
    built = robot.as_built.effects or ()
    mistakes = chain(
        robot.clashes(),
        wrong_effects(robot),
        wrong_entries(("as_built", "effects"), built, of_delta()),
    )
    if (first := next(mistakes, None)) is not None:
        raise document.fail_all(chain((first,), mistakes))
    return robot


def _also_wrong(data: dict[str, Any]) -> Iterator[Mistake]:
    """Mistakes that can be found beside others, so that all are mended in one round."""
    yield from named_twice(pins_named(data), _i2c_pins(data))
    yield from _clashes(valid_keys_of(RobotFile, data))
    yield from wrong_values(("effects",), data.get("effects"), of_delta())
    if isinstance(built := data.get("as_built"), dict):
        yield from wrong_values(("as_built", "effects"), built.get("effects"), of_delta())


def _i2c_pins(data: dict[str, Any]) -> dict[int, str]:
    """Pins that the bus of the distance sensors takes; none where there are no sensors."""
    ranging = data.get("ranging")
    bus = ranging.get("bus", 1) if isinstance(ranging, dict) else 1
    used = bus == 1 and data.get("sensors") is not None
    return dict.fromkeys(I2C_PINS, "the I2C bus") if used else {}


def check_said(robot: RobotFile) -> None:
    """Raise ConfigError when the robot file leaves open what hardware depends on."""
    if open_keys := robot.left_open():
        raise ConfigError(
            f"robot '{robot.name}' can be run simulated only: its file does not say "
            f"{', '.join(open_keys)}; write them down"
            " ('deltactl init delta FILE --wiring' asks for them)"
        )


def _clashes(sections: Mapping[str, Any]) -> Iterator[Mistake]:
    """Where sections of a robot file contradict each other: the key at fault, and what is wrong.

    In come sections each of which is valid by itself, not always all of them: a file's other
    mistakes must not keep a contradiction for the next round. A rule that needs a section that is
    not there says nothing.
    """
    for needed, contradictions in RULES:
        if all(name in sections for name in needed):
            yield from contradictions(*(sections[name] for name in needed))


def _home_within_limits(limits: Limits, homing: Homing) -> Iterator[Mistake]:
    low, high = limits.arm_deg
    for angle in homing.angle_deg:
        if not low <= angle <= high:
            says = f"{angle:g} is outside limits.arm_deg [{low:g}, {high:g}]"
            yield ("homing", "angle_deg"), says


def _inputs_named(built: AsBuilt, inputs: InputSettings) -> Iterator[Mistake]:
    for name in built.inputs:
        if name not in inputs.named:
            yield ("as_built", "inputs", name), "is no input of inputs.named"


def _servo_masses(drive: AnyDrive, masses: Masses | None) -> Iterator[Mistake]:
    if drive.kind == "servo" and masses is None:
        yield ("drive",), "kind servo needs a 'masses' section: the currents have to carry them"


def _servo_outputs(drive: AnyDrive, outputs: Mapping[str, object]) -> Iterator[Mistake]:
    if drive.kind == "servo" and outputs:
        yield ("outputs",), "robots with drive.kind servo have none"


def _servo_as_built(drive: AnyDrive, built: AsBuilt) -> Iterator[Mistake]:
    if drive.kind != "servo" and built.servo is not None:
        yield ("as_built", "servo"), "only robots with drive.kind servo have this section"


def _geared_down(drive: AnyDrive) -> Iterator[Mistake]:
    if drive.gear_ratio < LEAST_RATIO:
        says = f"{drive.gear_ratio:g}: {too_small_ratio(drive.gear_ratio)}"
        yield ("drive", "gear_ratio"), says


RULES: tuple[tuple[tuple[str, ...], Callable[..., Iterator[Mistake]]], ...] = (
    (("limits", "homing"), _home_within_limits),
    (("as_built", "inputs"), _inputs_named),
    (("drive",), _geared_down),
    (("drive", "masses"), _servo_masses),
    (("drive", "outputs"), _servo_outputs),
    (("drive", "as_built"), _servo_as_built),
)
"""The sections that a rule needs, and the rule."""
