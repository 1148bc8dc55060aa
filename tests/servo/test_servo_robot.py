"""The controller on the simulated servo robot: the same jobs, states and stops as a stepper's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import DriveAlarm, EmergencyStop, LimitExceeded, NotReady
from deltactl.models.linkage import Linkage, forward
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat_files import read_flat, write_flat
from deltactl.recording.tables.rounds import flatten

TEXT = (CONFIG_FOLDER / "uzunovic-2013.yaml").read_text(encoding="utf-8")
JOB = """name: {name}
robot: {robot}
path: {{shape: circle, centre_m: [0.0, 0.0, -0.075], radius_m: {radius_m}, spacing_m: 0.0001}}
timing: {{mode: accelerated, speed_mps: 0.02}}
inverse_kinematics: {kinematics}
"""
NETWORK = "{kind: network, file: uzunovic-2013.tflite}"
COUNT_RAD = np.deg2rad(0.01)

MakeController = Callable[..., Controller]


@pytest.fixture
def make(tmp_path: Path) -> Iterator[MakeController]:
    """A controller, on and homed, for the shipped robot with something added to its file."""
    made: list[Controller] = []

    def build(more: str = "", changes: tuple[tuple[str, str], ...] = ()) -> Controller:
        text = TEXT
        for was, becomes in changes:
            assert was in text
            text = text.replace(was, becomes)
        robot = tmp_path / "uzunovic-2013.yaml"
        robot.write_text(text + more, encoding="utf-8")
        controller = build_controller(
            robot, simulated=True, realtime=False, recordings=tmp_path / "recordings"
        )
        made.append(controller)
        controller.power_on()
        controller.home()
        return controller

    yield build
    for controller in made:
        controller.close()


@pytest.fixture
def submit(tmp_path: Path) -> Callable[..., int]:
    def go(
        controller: Controller,
        name: str = "little",
        radius_m: float = 0.003,
        kinematics: str = NETWORK,
    ) -> int:
        path = tmp_path / f"{name}.yaml"
        robot = tmp_path / "uzunovic-2013.yaml"
        path.write_text(
            JOB.format(name=name, robot=robot, radius_m=radius_m, kinematics=kinematics)
        )
        return controller.submit(path)

    return go


def finish(controller: Controller, number: int) -> JobResult:
    for _ in range(300):
        result = controller.result(number)
        if result is not None:
            return result
        sleep_s(controller.clock, 0.1)
    raise AssertionError("the job does not end within 30 s of robot time")


def until_moving(controller: Controller) -> None:
    sleep_s(controller.clock, 0.8)
    assert controller.status().state == "running"


def test_a_job_runs_and_the_arms_follow(make, submit, tmp_path: Path) -> None:
    """Cartesian targets, network, set-points, loop, plant: and back through the recording."""
    controller = make()
    result = finish(controller, submit(controller))
    assert (result.outcome, result.warning, result.recording_error) == ("done", "", "")
    run = read_run(Path(result.recording))
    assert run.complete
    assert run.edges.counts[-1].tolist() == run.targets.steps[-1].tolist()
    servo = run.servo
    rate_hz = 1e9 / np.median(np.diff(servo.t_ns))
    assert rate_hz == pytest.approx(500.0)
    path_ns = next(event.t_ns for event in run.events if event.kind == "path_start")
    on_path = servo.t_ns > path_ns
    behind = np.abs(servo.angle_rad - servo.reference_rad)[on_path]
    assert behind.max() < 5 * COUNT_RAD
    # The references are the counts of the edges, and those are the targets'.
    asked = run.edges.counts_at(servo.t_ns) * controller.robot.drive.rad_per_step
    assert np.abs(asked - servo.reference_rad)[on_path].max() < 0.2 * COUNT_RAD
    # The platform really went round: truth against the linkage at the measured angles.
    truth_rad = run.truth.angles_rad[-1]
    assert np.abs(truth_rad - servo.angle_rad[-1]).max() < 1.5 * COUNT_RAD
    reached = forward(Linkage.of(controller.robot.geometry), truth_rad).position_m
    assert np.abs(reached - run.truth.position_m[-1]).max() < 1e-6


def test_the_currents_carry_what_gravity_asks(make, submit) -> None:
    controller = make()
    result = finish(controller, submit(controller))
    servo = read_run(Path(result.recording)).servo
    settled = servo.t_ns > servo.t_ns[-1] - 200_000_000  # at rest at the end
    current = servo.current_a[settled].mean(axis=0)
    estimate = servo.disturbance_a[settled].mean(axis=0)
    assert np.abs(current - estimate).max() < 2e-3
    plant = controller.machine.drives.plant
    drive = controller.robot.drive
    torque = drive.gear_ratio * drive.torque_constant_nmpa
    gravity_a = np.array(plant.terms().load) / torque
    friction_a = drive.coulomb_nm / drive.torque_constant_nmpa
    assert (np.abs(current - gravity_a) <= friction_a * 1.05).all()
    assert (gravity_a < -0.01).all()  # the arms want to go down, so the motors pull up


def test_a_run_exports_to_the_contract_s_columns(make, submit, tmp_path: Path) -> None:
    controller = make()
    result = finish(controller, submit(controller))
    run = read_run(Path(result.recording))
    write_flat(flatten(run, with_truth=True), tmp_path / "flat.csv.gz")
    table = read_flat(tmp_path / "flat.csv.gz")
    for stem in ("command", "theta", "current", "disturbance"):
        assert table.motors(stem).shape == (len(table), 3)
    assert "steps_1" not in table.columns
    assert np.allclose(table.motors("theta"), run.servo.angle_rad, atol=1e-9)
    good = np.isfinite(table.axes("range")) & (np.nan_to_num(table.axes("status")) == 0)
    seen = good.sum(axis=0)
    assert (np.abs(seen - 50 * (table.t_s[-1] - table.t_s[0])) < 15).all()
    truth = np.stack([table.extra[f"truth_theta_{n}_rad"] for n in (1, 2, 3)], axis=1)
    apart = np.abs(truth - table.motors("theta"))
    assert np.nanmax(apart) < 12 * COUNT_RAD  # truth is recorded 50 times a second


@pytest.mark.study
def test_the_same_run_twice_is_the_same(make, submit) -> None:
    runs = []
    for _ in range(2):
        controller = make()
        result = finish(controller, submit(controller))
        runs.append(read_run(Path(result.recording)).servo)
    assert np.array_equal(runs[0].current_a, runs[1].current_a)


@pytest.mark.study
def test_pause_and_resume_keep_to_the_path(make, submit) -> None:
    controller = make()
    number = submit(controller)
    until_moving(controller)
    controller.pause()
    sleep_s(controller.clock, 1.0)
    before = controller.machine.drives.plant.angles_rad()
    sleep_s(controller.clock, 0.5)
    after = controller.machine.drives.plant.angles_rad()
    assert np.abs(np.subtract(before, after)).max() < 2 * COUNT_RAD
    controller.resume()
    result = finish(controller, number)
    assert result.outcome == "done"
    run = read_run(Path(result.recording))
    assert run.edges.counts[-1].tolist() == run.targets.steps[-1].tolist()


def test_homing_again_brings_the_arms_back(make, submit) -> None:
    controller = make()
    finish(controller, submit(controller))
    controller.home()
    at_deg = np.rad2deg(controller.machine.drives.plant.angles_rad())
    assert at_deg == pytest.approx([30.0] * 3, abs=0.03)


def test_the_limits_are_the_same(make, submit) -> None:
    controller = make()
    with pytest.raises(LimitExceeded, match="outside what uzunovic-2013"):
        submit(controller, radius_m=0.02)


def test_the_e_stop_takes_the_current_away(make, submit) -> None:
    controller = make()
    number = submit(controller)
    until_moving(controller)
    controller.machine.bench.press_estop()
    sleep_s(controller.clock, 0.02)
    status = controller.status()
    assert (status.state, status.why) == ("stopped", "e-stop")
    assert not controller.machine.drives.enabled
    held = controller.machine.drives.plant.angles_rad()
    sleep_s(controller.clock, 1.0)
    assert controller.machine.drives.plant.angles_rad() == held  # by the brakes
    assert controller.result(number).outcome == "stopped"
    with pytest.raises(NotReady, match="the robot is stopped"):
        submit(controller, "refused")
    with pytest.raises(EmergencyStop, match="e-stop is pressed"):
        controller.acknowledge()
    controller.machine.bench.release_estop()
    controller.acknowledge()
    with pytest.raises(NotReady, match="unhomed"):
        submit(controller, "unhomed")


@pytest.mark.study
@pytest.mark.parametrize("joint", [1, 2, 3])
def test_a_lost_encoder_is_a_safe_stop_that_names_the_joint(make, submit, joint: int) -> None:
    controller = make()
    number = submit(controller)
    until_moving(controller)
    controller.machine.drives.fail("encoder_lost", joint)
    sleep_s(controller.clock, 0.011)
    status = controller.status()
    assert status.state == "fault"
    assert f"encoder signal of motor{joint} is lost" in status.why
    assert not controller.machine.drives.enabled
    result = controller.result(number)
    assert result.outcome == "fault"
    assert read_run(Path(result.recording)).complete
    with pytest.raises(NotReady, match=f"motor{joint}"):
        submit(controller, "refused")
    with pytest.raises(DriveAlarm, match=f"motor{joint}"):
        controller.acknowledge()
    assert controller.status().state == "fault"
    controller.machine.drives.mend(joint)
    controller.acknowledge()
    with pytest.raises(NotReady, match="unhomed"):
        submit(controller, "unhomed")
    controller.power_off()
    controller.power_on()
    controller.home()
    assert finish(controller, submit(controller, "again")).outcome == "done"


def test_a_drive_that_trips_is_a_fault(make, submit) -> None:
    controller = make()
    submit(controller)
    until_moving(controller)
    controller.machine.drives.fail("over_current", 3)
    sleep_s(controller.clock, 0.011)
    assert "drive of motor3 has tripped: over-current" in controller.status().why


def test_an_arm_that_cannot_follow_is_a_fault_that_names_it(make, submit) -> None:
    """Dry friction of joint 2 far beyond what the current limit can overcome."""
    controller = make(
        "as_built: {servo: {coulomb_scale: [1, 10, 1]}}\n", (("limit_a: 0.8", "limit_a: 0.15"),)
    )
    result = finish(controller, submit(controller))
    assert result.outcome == "fault"
    assert "motor2" in result.why
    assert "following error" in result.why or "over-current" in result.why


def test_an_overloaded_drive_is_a_fault(make, submit) -> None:
    """Friction of joint 3 beyond the current limit, and a guard that lets an arm lag far."""
    controller = make(
        "as_built: {servo: {coulomb_scale: [1, 1, 10]}}\n",
        (
            ("limit_a: 0.8", "limit_a: 0.15"),
            ("following_error_deg: 2.0", "following_error_deg: 80\n  overload_s: 0.1"),
        ),
    )
    result = finish(controller, submit(controller))
    assert result.outcome == "fault"
    assert "over-current of motor3: at its limit for more than 0.1 s" in result.why


def test_without_brakes_the_arms_drop(make, submit) -> None:
    controller = make(changes=(("brake: holding", "brake: none"),))
    submit(controller)
    until_moving(controller)
    before = controller.machine.drives.plant.angles_rad()
    controller.stop("a hand in the way")
    sleep_s(controller.clock, 1.0)
    after = controller.machine.drives.plant.angles_rad()
    assert max(np.subtract(after, before)) > 0.3


def test_a_controller_that_goes_silent_stops_the_arms(make, submit) -> None:
    controller = make()
    submit(controller)
    until_moving(controller)
    controller.machine.output.beat = lambda: None  # type: ignore[method-assign]
    controller._control_task.stop()
    sleep_s(controller.clock, 0.5)
    seen = controller.machine.output.status()
    assert seen.state.value in ("stopped", "ready")
    assert seen.queued == 0
    standing = controller.machine.drives.plant.angles_rad()
    sleep_s(controller.clock, 0.3)
    moved = np.subtract(controller.machine.drives.plant.angles_rad(), standing)
    assert np.abs(moved).max() < 2 * COUNT_RAD


@pytest.mark.study
def test_homing_by_switches(make, submit) -> None:
    switches = "method: switch\n  switch_pins: [7, 8, 9]\n  speed_radps: 0.5"
    controller = make(changes=(("method: placed", switches),))
    at_deg = np.rad2deg(controller.machine.drives.plant.angles_rad())
    assert at_deg == pytest.approx([30.0] * 3, abs=0.7)
    assert finish(controller, submit(controller)).outcome == "done"
