"""Faults beside a run: while the robot is homed, waits or pauses, or just begins."""

from __future__ import annotations

import re
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from random import Random

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import State, said
from deltactl.foundation.errors import DeltactlError
from tests.rigs.faults.edges import after, edge_times_ns
from tests.rigs.faults.stand import ROBOT_FILE, Stand, wait_for
from tests.rigs.faults.verdict import Verdict
from tests.rigs.switch_homing import SIGHTS, TROUBLES, home_with

SEEN_S = 1.2
SAGGED_STEPS = 160
"""3.6 degrees of an arm: 10 mm of a range and more."""
REFUSING = 4
"""A raw status of the chip that makes every sample refused."""
RestFault = Callable[[Stand, Random, Verdict], None]


def push_ready(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """An arm is pushed by 9 degrees while the robot waits."""
    _homed(stand)
    time.sleep(1.5)
    stand.bench.slip(chance.randint(1, 3), chance.choice((-1, 1)) * 400)
    _ends_as(stand, verdict, "unhomed", "an arm moved .* motor[123]")


def power_lost_ready(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """All arms sink at once while the robot waits."""
    _homed(stand)
    time.sleep(1.5)
    for motor in (1, 2, 3):
        stand.bench.slip(motor, -400)
    _ends_as(stand, verdict, "unhomed", "drive power lost")


def push_paused(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """An arm is pushed by 9 degrees while a job is paused."""
    stand.ensure_running()
    time.sleep(1.0)
    stand.controller.pause()
    time.sleep(1.5)
    stand.bench.slip(chance.randint(1, 3), chance.choice((-1, 1)) * 400)
    _ends_as(stand, verdict, "fault", "lost steps: .* motor[123]")


def sag_ready(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """An arm sags step by step while the robot waits, too slowly to be seen as a push."""
    _homed(stand)
    time.sleep(1.5)
    motor, sign = chance.randint(1, 3), chance.choice((-1, 1))
    for _ in range(SAGGED_STEPS):
        stand.bench.slip(motor, sign)
        time.sleep(0.03)
    _ends_as(stand, verdict, "unhomed", f"an arm moved .* motor{motor}")


def lie_ready(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """A sensor says another distance while the robot waits, with a good status."""
    _homed(stand)
    time.sleep(1.5)
    axis = chance.choice("xy")
    stand.rig.chips[axis].faults.offset_m = chance.choice((-1, 1)) * chance.uniform(0.02, 0.2)
    _ends_as(stand, verdict, "unhomed", f"sensor {axis} reads")
    stand.rig.chips[axis].faults.clear()


def stop_homing(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """A stop while the arms are homed, acknowledged before the homing has noticed."""
    _homed(stand)
    refused: list[str] = []

    def home() -> None:
        try:
            stand.controller.home()
        except DeltactlError as error:
            refused.append(str(error))

    thread = threading.Thread(target=home)
    thread.start()
    time.sleep(chance.uniform(0.05, 0.25))
    stand.controller.stop("a hand in the way")
    stand.controller.acknowledge()
    stopped_ns = time.monotonic_ns()
    thread.join(5.0)
    verdict.demand(bool(refused), "the homing went on over a stop")
    _ends_as(stand, verdict, "unhomed", "")
    moved = len(after(edge_times_ns(stand.bench.memory), stopped_ns))
    verdict.demand(moved == 0, f"{moved} edges after the stop")


def stop_beginning(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """A stop at the very beginning of a job, with another one waiting."""
    _homed(stand)
    numbers = [stand.controller.submit(stand.job), stand.controller.submit(stand.job)]
    time.sleep(chance.uniform(0.0, 0.02))
    stand.controller.stop("a hand in the way")
    stopped_ns = time.monotonic_ns()
    _ends_as(stand, verdict, "stopped", "^a hand in the way$")
    time.sleep(0.3)
    moved = len(after(edge_times_ns(stand.bench.memory), stopped_ns + 5_000_000))
    verdict.demand(moved == 0, f"{moved} edges after the stop")
    results = [wait_for_result(stand.controller, number) for number in numbers]
    verdict.demand(results == ["stopped", "stopped"], f"results {results}")
    verdict.demand(stand.controller.journal.path is None, "a recording is still open")


def home_blind(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """A sensor refuses every sample while the robot is to be homed."""
    _homed(stand)
    stand.controller.power_off()
    stand.controller.power_on()
    axis = chance.choice("xyz")
    stand.rig.chips[axis].faults.raw_status = REFUSING
    try:
        stand.controller.home()
        verdict.demand(False, "homed without seeing the arms")
    except DeltactlError as error:
        figure = re.search(rf"sensor {axis}.* by (\d+) degrees unseen", str(error))
        verdict.demand(figure is not None, f"refused for another reason: {error}")
    stand.rig.chips[axis].faults.clear()
    verdict.demand(stand.state == "unhomed", f"refused, and {stand.state}")


def change_file(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """The robot file is written over while the robot is on: said, and not recorded."""
    folder = stand.folder / "in-force"
    folder.mkdir(exist_ok=True)
    robot_file = folder / ROBOT_FILE.name
    before = ROBOT_FILE.read_text()
    robot_file.write_text(before)
    with closing(_virtual(robot_file, folder)) as controller:
        controller.power_on()
        controller.home()
        robot_file.write_text(before.replace("upper_arm_m: 0.25 ", "upper_arm_m: 0.26 "))
        said = controller.status().robot_file_changed
        verdict.demand("has changed since it was read" in said, f"the status says {said!r}")
        verdict.demand(controller.robot.geometry.upper_arm_m == 0.25, "another file is in force")


def no_place_to_record(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """The recording of a job cannot be begun: refused with the reason, and the next one runs."""
    _homed(stand)
    in_the_way = stand.folder / "in-the-way"
    in_the_way.write_text("")
    record = in_the_way / f"{chance.randrange(1000)}.mcap"
    begun_ns = time.monotonic_ns()
    number = stand.controller.submit(stand.job, record)
    outcome = wait_for_result(stand.controller, number)
    result = stand.controller.result(number)
    verdict.demand(outcome == "refused", f"ended as {outcome}")
    why = "" if result is None else result.why
    verdict.demand(str(in_the_way) in why and "cannot be made" in why, f"the reason is {why!r}")
    named = None if result is None else result.recording
    verdict.demand(named is None, f"names a recording that there is not: {named}")
    moved = len(after(edge_times_ns(stand.bench.memory), begun_ns))
    verdict.demand(moved == 0, f"{moved} edges without a recording")
    verdict.demand(stand.state == "ready", f"refused, and {stand.state}")
    stand.ensure_running()


def switch_trouble(name: str) -> RestFault:
    """Something is wrong with a switch, its wire or its arm; see tests/rigs/switch_homing.py."""

    def fault(stand: Stand, chance: Random, verdict: Verdict) -> None:
        with tempfile.TemporaryDirectory() as folder:
            sight = chance.choice(SIGHTS)
            drawn, outcome = home_with([name], sight, chance, Path(folder))
            for problem in outcome.problems:
                verdict.demand(False, f"{drawn}: {problem}")

    return fault


REST_KINDS: dict[str, RestFault] = {
    "arm pushed while ready": push_ready,
    "drive power lost while ready": power_lost_ready,
    "arm pushed while paused": push_paused,
    "stop during homing": stop_homing,
    "stop as a job begins": stop_beginning,
    "homing with a sensor blind": home_blind,
    "robot file changed": change_file,
    "no place to record": no_place_to_record,
    "arm sags while ready": sag_ready,
    "sensor lies while ready": lie_ready,
    **{f"home switch: {name}": switch_trouble(name) for name in TROUBLES},
}


def try_at_rest(stand: Stand, name: str, fault: RestFault, chance: Random) -> Verdict:
    """Make the fault, judge it, and leave the stand fit for the next."""
    verdict = Verdict(name)
    try:
        fault(stand, chance, verdict)
    except (DeltactlError, AssertionError, OSError) as error:
        verdict.demand(False, f"{type(error).__name__}: {error}")
        stand.restart()
    stand.run = None
    return verdict


def wait_for_result(controller: Controller, number: int) -> str:
    """How a job ended; empty when it does not within a while."""
    wait_for(lambda: controller.result(number) is not None, 5.0)
    result = controller.result(number)
    return "" if result is None else result.outcome


def _homed(stand: Stand) -> None:
    stand.end_run()
    stand.make_ready()


def _virtual(robot_file: Path, folder: Path) -> Controller:
    return build_controller(robot_file, simulated=True, realtime=False, recordings=folder)


def _ends_as(stand: Stand, verdict: Verdict, state: str, culprit: str) -> None:
    start_s = time.monotonic()
    reached = wait_for(lambda: stand.state == state, SEEN_S)
    verdict.seen_s = time.monotonic() - start_s
    verdict.demand(reached is not None, f"is {stand.state}, not {state}")
    why = stand.controller.status().why
    verdict.demand(re.search(culprit, why) is not None, f"culprit not named: {why!r}")
    try:
        stand.controller.submit(stand.job)
        verdict.demand(False, f"took a job while {state}")
    except DeltactlError as error:
        verdict.demand(
            f"the robot is {said(State(state))}" in str(error), f"refused otherwise: {error}"
        )
