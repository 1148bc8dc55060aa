"""The whole robot file: model, wiring, limits and, for simulation, how it was really built."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from drivers.settings import InputSettings, Pin, RangingSettings, StepSettings
from foundation.errors import ConfigError
from foundation.strict_yaml import Document, StrictModel
from models.robot import KINDS, DeltaRobot, Drive, EffectEntry

Rate = Annotated[float, Field(gt=0.0)]


class Limits(StrictModel):
    """What no motion may exceed; checked along the whole path before anything moves."""

    arm_deg: tuple[float, float] = (-20.0, 110.0)
    box_m: tuple[tuple[float, float], tuple[float, float], tuple[float, float]] | None = None
    """Cartesian box (x, y, z), each (low, high)."""
    step_rate_hz: Annotated[float, Field(gt=0.0, le=500_000.0)] = 20_000.0
    """CL57T takes 500 kHz; the pulse process on a Pi is good for about 10 to 20 kHz."""
    joint_speed_radps: Annotated[float, Field(gt=0.0)] = 2.0
    joint_acceleration_radps2: Annotated[float, Field(gt=0.0)] = 20.0
    singularity_margin: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.05
    """Smallest |sin| between upper arm and forearm plane that a path may come to."""

    @model_validator(mode="after")
    def _ordered(self) -> Limits:
        if self.arm_deg[0] >= self.arm_deg[1]:
            raise ValueError("arm_deg must be [lowest, highest]")
        for low, high in self.box_m or ():
            if low >= high:
                raise ValueError("box_m must be three pairs of [lowest, highest]")
        return self


class Homing(StrictModel):
    """How the robot learns where its arms are: put against their stops, or by a switch an arm."""

    method: Literal["placed", "switch"] = "placed"
    angle_deg: tuple[float, float, float] = (-20.0, -20.0, -20.0)
    switch_pins: tuple[Pin, Pin, Pin] | None = None
    switch_active_high: bool = False
    speed_radps: Annotated[float, Field(gt=0.0, le=1.0)] = 0.1
    tolerance_m: Annotated[float, Field(gt=0.0)] = 0.03
    """How far the sensors may disagree with the home angles before homing is refused."""

    @model_validator(mode="after")
    def _has_switches(self) -> Homing:
        if self.method == "switch" and self.switch_pins is None:
            raise ValueError("method 'switch' needs switch_pins")
        return self


class SensorNoise(StrictModel):
    """Noise of a simulated ranging sensor."""

    sigma_m: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0015
    correlation: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 1


class AsBuilt(StrictModel):
    """How the simulated robot differs from its file; the controller never reads this."""

    effects: tuple[EffectEntry, ...] = ()
    noise: SensorNoise = SensorNoise()


class RobotFile(DeltaRobot):
    """A delta robot with its wiring and limits."""

    drive: Drive
    steps: StepSettings = StepSettings()
    inputs: InputSettings = InputSettings()
    ranging: RangingSettings = RangingSettings()
    limits: Limits = Limits()
    homing: Homing = Homing()
    as_built: AsBuilt = AsBuilt()

    @model_validator(mode="after")
    def _pins_differ(self) -> RobotFile:
        steps = self.steps
        used = [*steps.step_pins, *steps.direction_pins, *self.ranging.xshut_pins]
        used += [*(steps.alarm_pins or ()), *(self.homing.switch_pins or ())]
        used += [pin for pin in (steps.enable_pin, self.inputs.estop_pin) if pin is not None]
        twice = sorted({pin for pin in used if used.count(pin) > 1})
        if twice:
            raise ValueError(f"GPIO {twice[0]} is used twice; every signal needs a pin of its own")
        return self


def load_robot(path: Path) -> RobotFile:
    """Read a robot file for running. Raises MissingFile or ConfigError (one line)."""
    document = Document.read(path)
    kind = document.data.get("kind")
    if kind != "delta":
        known = "cannot be run, only diagnosed" if kind in KINDS else "must be 'delta'"
        raise document.fail(("kind",), f"{known} (got {kind!r})")
    return document.check(RobotFile)


CONFIG_FOLDER = Path(__file__).resolve().parent.parent / "config"


def find(name: str, beside: Path | None = None) -> Path:
    """Where a named file is: as given, beside the file that names it, or in `config/`.

    Raises MissingFile.
    """
    given = Path(name)
    places = [given] if beside is None else [beside.parent / given]
    places.append(CONFIG_FOLDER / given)
    for place in places:
        if place.is_file():
            return place
    here = sorted(path.name for path in CONFIG_FOLDER.glob("*.yaml"))
    raise ConfigError(f"{name}: no such file here or in config/; there are {', '.join(here)}")
