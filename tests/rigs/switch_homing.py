"""Homing by switches, drawn at random: what is wrong with switches, drives and sensors, and whether
the outcome is one of the two that are specified."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import numpy as np
import yaml

from deltactl.drivers.fakes.mock_pins import FakeHomeSwitch, exchange
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.switch_search import MARGIN_RAD
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import Task, ns, sleep_s
from deltactl.foundation.errors import NotReady
from deltactl.models.robot import FloatArray

ACCEPTED_DEG = 360.0
"""Somebody has looked at the arms, where a sensor does not."""
REFUSING = 4
"""A raw status of the chip that makes every sample refused."""
OVER_DEG = np.degrees(MARGIN_RAD) + 3.0
"""Past the limits: the stated margin, and what the sensors may be wrong by in seeing the start."""


def switch_robot(
    folder: Path, home_deg: float = 30.0, sensors: bool = True, **homing: object
) -> Path:
    """A robot file with home switches."""
    data = yaml.safe_load((CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8"))
    data["homing"] = {
        "method": "switch",
        "angle_deg": [home_deg] * 3,
        "switch_pins": [12, 16, 18],
        **homing,
    }
    if not sensors:
        del data["sensors"]
    path = folder / f"switched-{home_deg:g}-{sensors:d}.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return path


def switch_of(controller: Controller, motor: int) -> FakeHomeSwitch:
    """The simulated switch of an arm (0 to 2)."""
    one = controller.machine.home_switches[motor]
    assert isinstance(one, FakeHomeSwitch)
    return one


def arms_deg(controller: Controller) -> FloatArray:
    """Where the simulated arms really are."""
    assert controller.machine.world is not None
    return np.rad2deg(controller.machine.world.truth(controller.clock.now_ns()).angles_rad)


def begin_at(controller: Controller, motor: int, arm_deg: float) -> None:
    """Turn an arm to where it is when homing begins; the drives must be on."""
    assert controller.machine.bench is not None
    off_deg = float(arms_deg(controller)[motor]) - arm_deg
    controller.machine.bench.slip(
        motor + 1, round(np.deg2rad(off_deg) / controller.robot.drive.rad_per_step)
    )


@dataclass
class Outcome:
    """What came of it."""

    refused: str = ""
    home_error_deg: float = 0.0
    """Of the worst arm, once homed."""
    lowest_deg: float = 0.0
    """How far the highest arm went: smaller angles are higher."""
    problems: list[str] = field(default_factory=list)


def home_and_judge(
    controller: Controller, named: str = "", bound_deg: float | None = None
) -> Outcome:
    """Home; either home is right to the tolerance, or it is refused in one line that says why.

    named: what a refusal must match. bound_deg: above which no arm may come.
    """
    outcome, homing = Outcome(), controller.robot.homing
    highest = Highest(controller)
    try:
        controller.home(ACCEPTED_DEG)
    except NotReady as error:
        outcome.refused = str(error)
    outcome.lowest_deg = highest.angle_deg
    low_deg = controller.robot.limits.arm_deg[0] - OVER_DEG if bound_deg is None else bound_deg
    if outcome.lowest_deg < low_deg:
        outcome.problems.append(f"an arm came to {outcome.lowest_deg:.1f} degrees")
    if highest.sunk_deg > controller.robot.limits.arm_deg[1] + OVER_DEG:
        outcome.problems.append(f"an arm sank to {highest.sunk_deg:.1f} degrees")
    if outcome.refused:
        _judge_refusal(outcome, controller, named)
        return outcome
    off_deg = np.abs(arms_deg(controller) - np.array(homing.angle_deg)).max()
    step_deg = np.degrees(controller.robot.drive.rad_per_step)
    outcome.home_error_deg = float(off_deg)
    if off_deg > homing.switch_tolerance_deg + step_deg:
        outcome.problems.append(f"homed {off_deg:.2f} degrees off")
    return outcome


def _judge_refusal(outcome: Outcome, controller: Controller, named: str) -> None:
    said = outcome.refused
    if controller.status().state != "unhomed":
        outcome.problems.append(f"refused, and {controller.status().state}")
    if "\n" in said or not re.search(r"arm [123]|motor[ 123]|sensor [xyz]|all arms", said):
        outcome.problems.append(f"names nothing: {said}")
    if named and not re.search(named, said):
        outcome.problems.append(f"names another culprit than {named}: {said}")


class Highest:
    """Watches how high the arms rise, and how far they sink."""

    def __init__(self, controller: Controller):
        self.angle_deg, self.sunk_deg = 1e9, -1e9
        self._controller = controller
        controller.clock.start("watching", self._task(), _raise)

    def _task(self) -> Task:
        while True:
            angles_deg = arms_deg(self._controller)
            self.angle_deg = min(self.angle_deg, float(angles_deg.min()))
            self.sunk_deg = max(self.sunk_deg, float(angles_deg.max()))
            yield self._controller.clock.now_ns() + ns(0.05)


def _raise(error: BaseException) -> None:
    raise error


Trouble = Callable[[Controller, int, Random], str]
"""Makes something wrong with an arm; returns what a refusal must name, empty for anything."""


def _one_glitch(one: Controller, motor: int, chance: Random) -> str:
    switch_of(one, motor).faults.false_at = frozenset({chance.randint(1, 1500)})
    return "no refusal"


def _false_2(one: Controller, motor: int, chance: Random) -> str:
    faults = switch_of(one, motor).faults
    faults.false_rate, faults.seed = 0.02, chance.randint(1, 999)
    return ""


def _false_5(one: Controller, motor: int, chance: Random) -> str:
    faults = switch_of(one, motor).faults
    faults.false_rate, faults.seed = 0.05, chance.randint(1, 999)
    return ""


def _stuck_open(one: Controller, motor: int, chance: Random) -> str:
    switch_of(one, motor).faults.stuck = False
    return rf"arm {motor + 1}\b.*stuck open"


def _stuck_closed(one: Controller, motor: int, chance: Random) -> str:
    switch_of(one, motor).faults.stuck = True
    return rf"arm {motor + 1}\b.*stuck closed"


def _bounces(one: Controller, motor: int, chance: Random) -> str:
    switch_of(one, motor).faults.bounces = chance.choice((2, 3, 4, 10))
    return rf"arm {motor + 1}\b"


def _exchanged(one: Controller, motor: int, chance: Random) -> str:
    other = chance.choice([arm for arm in range(3) if arm != motor])
    exchange(switch_of(one, motor), switch_of(one, other))
    return "exchanged|another arm's"


def _late_once(one: Controller, motor: int, chance: Random) -> str:
    late_rad = chance.uniform(0.004, 0.02)
    courses = ([late_rad, 0.0], [0.0, late_rad, 0.0], [0.0, 0.0, late_rad, 0.0])
    switch_of(one, motor).faults.late_rad = chance.choice(courses)
    return rf"arm {motor + 1}\b"


def _far_below(one: Controller, motor: int, chance: Random) -> str:
    begin_at(one, motor, chance.uniform(45.0, 105.0))
    return rf"arm {motor + 1}\b"


def _above(one: Controller, motor: int, chance: Random) -> str:
    begin_at(one, motor, one.robot.homing.angle_deg[motor] - chance.uniform(0.0, 12.0))
    return rf"arm {motor + 1}\b"


def _loses_steps(one: Controller, motor: int, chance: Random) -> str:
    """Now and then while approaching, in either direction."""
    bench = one.machine.bench
    assert bench is not None

    def task() -> Task:
        yield one.clock.now_ns() + ns(chance.uniform(0.1, 8.0))
        bench.slip(motor + 1, chance.choice((-1, 1)) * chance.randint(6, 60))

    one.clock.start("slipping", task(), _raise)
    return rf"arm {motor + 1}\b|arms? |sensor"


def _held(one: Controller, motor: int, chance: Random) -> str:
    assert one.machine.bench is not None
    one.machine.bench.stall(motor + 1)
    return rf"arm {motor + 1}\b"


TROUBLES: dict[str, Trouble] = {
    "one false reading": _one_glitch,
    "2 % false readings": _false_2,
    "5 % false readings": _false_5,
    "stuck open": _stuck_open,
    "stuck closed": _stuck_closed,
    "bounces": _bounces,
    "wires exchanged": _exchanged,
    "closes late once": _late_once,
    "begins far below": _far_below,
    "begins above": _above,
    "loses steps": _loses_steps,
    "motor held fast": _held,
}
SIGHTS = ("three sensors", "a sensor refuses", "no sensors")


def draw(number: int, folder: Path) -> tuple[str, Outcome]:
    """One draw: a home angle, what the sensors see, and one trouble or two. Says what it was."""
    chance = Random(number)
    sight = chance.choice(SIGHTS)
    names = chance.sample(sorted(TROUBLES), chance.choice((1, 1, 2)))
    drawn, outcome = home_with(names, sight, chance, folder)
    return f"{number}: {drawn}", outcome


def home_with(
    names: Sequence[str], sight: str, chance: Random, folder: Path
) -> tuple[str, Outcome]:
    """Home by switches with these troubles, each of a random arm. Says what was drawn."""
    home_deg = chance.choice((0.0, 10.0, 30.0))
    robot = switch_robot(folder, home_deg, sight != "no sensors")
    seed = chance.randint(0, 9999)
    made = build_controller(robot, simulated=True, realtime=False, recordings=folder, seed=seed)
    with closing(made) as one:
        one.power_on()
        if sight == "a sensor refuses":
            assert one.machine.rig is not None
            one.machine.rig.chips[chance.choice("xyz")].faults.raw_status = REFUSING
        named = [TROUBLES[name](one, chance.randrange(3), chance) for name in names]
        single = named[0] if len(named) == 1 else ""
        sleep_s(one.clock, 0.01)  # until the simulated arms have been worked out anew
        begin_deg = float(arms_deg(one).min())
        outcome = home_and_judge(one, single, _bound_deg(one, begin_deg))
    return f"{home_deg:g} degrees, {sight}, {' and '.join(names)}", outcome


def _bound_deg(one: Controller, begin_deg: float) -> float:
    """The limits and the margin; an arm that began above its switch rises as far again unseen."""
    above_deg = max(0.0, one.robot.homing.angle_deg[0] - begin_deg)
    return float(one.robot.limits.arm_deg[0] - OVER_DEG - above_deg)
