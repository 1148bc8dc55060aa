"""A robot that does not see its arms: it does not count as homed, and does not go on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.sensing.determined import determine, unseen_rad
from deltactl.firmware_py.controller.sensing.home_check import check_plausible, expected_ranges_m
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.controller.sensing.sight import BLIND_S, Blindness, Sight
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import VirtualClock, ns, sleep_s
from deltactl.foundation.errors import NotReady
from deltactl.models.linkage import Linkage, forward

ROBOT = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
OUT_OF_BOUNDS = 4
"""A raw status of the chip that refuses the sample (ULD 4)."""


def seen_m(*angles_deg: float, missing: str = "") -> np.ndarray:
    """Ranges with the arms at these angles."""
    assert ROBOT.sensors is not None
    pose = forward(Linkage.of(ROBOT.geometry), np.deg2rad(angles_deg))
    ranges_m = ROBOT.sensors.offsets_m + ROBOT.sensors.axes @ pose.position_m
    ranges_m[["xyz".index(axis) for axis in missing]] = np.nan
    return ranges_m


def test_a_symmetric_pose_is_not_home_without_the_sensor_that_would_show_it() -> None:
    """All arms 40 degrees off: x and y agree to 0.0 mm."""
    two = seen_m(70.0, 70.0, 70.0, missing="z")
    with pytest.raises(NotReady, match=r"sensor z, so that an arm could be off by (\d+) degrees"):
        check_plausible(ROBOT, two)
    with pytest.raises(NotReady, match="sensor z reads"):
        check_plausible(ROBOT, seen_m(70.0, 70.0, 70.0))


@pytest.mark.parametrize("missing", ["x", "y", "z", "xy", "yz", "xyz"])
def test_what_is_said_to_be_unseen_holds_for_any_pose_that_agrees(missing: str) -> None:
    """Whatever arms the good ranges cannot tell from home are within the figure that is printed."""
    good = np.array([axis not in missing for axis in "xyz"])
    assert not determine(ROBOT, good)
    limit_deg = np.rad2deg(unseen_rad(ROBOT, good, ROBOT.homing.tolerance_m))
    home_m = expected_ranges_m(ROBOT)
    chance = np.random.default_rng(1)
    tried_deg = chance.uniform(-20.0, 110.0, (4000, 3))
    tried_deg[:500] = tried_deg[:500, :1]  # symmetric poses among them
    pose_m = forward(Linkage.of(ROBOT.geometry), np.deg2rad(tried_deg)).position_m
    assert ROBOT.sensors is not None
    off_m = np.abs(ROBOT.sensors.offsets_m + pose_m @ ROBOT.sensors.axes.T - home_m)[:, good]
    alike = (off_m <= ROBOT.homing.tolerance_m).all(axis=1)
    assert alike.sum() > 10
    assert np.abs(tried_deg[alike] - 30.0).max() <= limit_deg
    assert limit_deg >= 40.0


def test_three_good_ranges_determine_the_arms_and_say_how_well() -> None:
    every = np.ones(3, dtype=bool)
    assert determine(ROBOT, every)
    limit_deg = np.rad2deg(unseen_rad(ROBOT, every, ROBOT.homing.tolerance_m))
    said = check_plausible(ROBOT, seen_m(30.0, 30.0, 30.0)).says()
    assert said == (
        "sensors agree with the home angles to 0.0 mm; they would not notice an arm that is less"
        f" than {np.ceil(limit_deg):.0f} degrees off, so look whether each arm is against its stop"
    )
    # Near home the linear estimate is the truth to a tenth, over all poses within the tolerance.
    chance = np.random.default_rng(2)
    tried_deg = 30.0 + chance.uniform(-12.0, 12.0, (40_000, 3))
    pose_m = forward(Linkage.of(ROBOT.geometry), np.deg2rad(tried_deg)).position_m
    assert ROBOT.sensors is not None
    off_m = ROBOT.sensors.offsets_m + pose_m @ ROBOT.sensors.axes.T - expected_ranges_m(ROBOT)
    alike = (np.abs(off_m) <= ROBOT.homing.tolerance_m).all(axis=1)
    furthest_deg = np.abs(tried_deg[alike] - 30.0).max()
    assert 0.75 * limit_deg < furthest_deg < 1.15 * limit_deg


def test_placed_arms_that_are_a_little_off_are_worth_a_second_look() -> None:
    said = check_plausible(ROBOT, seen_m(32.0, 32.0, 32.0))
    assert "sensor z is 18." in said.warning
    assert "homing.warning_m: 10 mm" in said.warning
    assert check_plausible(ROBOT, seen_m(30.5, 30.5, 30.5)).warning == ""


def test_switches_do_not_make_up_for_a_sensor_that_is_refused() -> None:
    """Only a robot that was built without sensors is homed by its switches alone."""
    homing = ROBOT.homing.model_copy(update={"method": "switch"})
    switched = ROBOT.model_copy(update={"homing": homing})
    with pytest.raises(NotReady, match="no good reading from sensor z"):
        check_plausible(switched, seen_m(30.0, 30.0, 30.0, missing="z"))
    nothing = np.full(3, np.nan)
    assert check_plausible(switched.model_copy(update={"sensors": None}), nothing).warning == ""


def blind_one(controller: Controller, axis: str = "z") -> None:
    assert controller.machine.rig is not None
    controller.machine.rig.chips[axis].faults.raw_status = OUT_OF_BOUNDS


def test_homing_with_a_sensor_refused_needs_a_person_and_the_figure(controller: Controller) -> None:
    controller.power_on()
    blind_one(controller)
    sleep_s(controller.clock, 0.2)
    with pytest.raises(NotReady, match=r"'deltactl home --accept-unseen (\d+)'") as refused:
        controller.home()
    assert controller.status().state == "unhomed"
    figure = float(str(refused.value).split("--accept-unseen ")[1].split("'")[0])
    with pytest.raises(NotReady, match="homing refused"):
        controller.home(accept_unseen_deg=figure - 1.0)
    assert f"less than {figure:.0f} degrees off" in controller.home(accept_unseen_deg=figure).text
    assert controller.status().state == "ready"


def test_homing_does_not_take_what_was_read_before(controller: Controller) -> None:
    """Good readings from before the look, then none: what is old says nothing."""
    controller.power_on()
    sleep_s(controller.clock, 0.3)
    assert controller.status().sensors[2].gate == "good"
    blind_one(controller)
    with pytest.raises(NotReady, match="no good reading from sensor z"):
        controller.home()


@pytest.mark.parametrize("axes", ["z", "x", "xyz"])
def test_a_blind_robot_stops_and_says_since_when(homed: Controller, write_job, axes: str) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 3.0)
    assert homed.status().state == "running"
    for axis in axes:
        blind_one(homed, axis)
    sleep_s(homed.clock, BLIND_S - 0.1)
    assert homed.status().state == "running"
    sleep_s(homed.clock, 0.2)
    status = homed.status()
    assert status.state == "fault"
    assert status.why.startswith(f"blind: no good reading of sensor {axes[0]} (refused: status)")
    assert status.blind_s == pytest.approx(BLIND_S + 0.1, abs=0.05)
    for sensor in status.sensors:
        assert sensor.health.startswith("blind for 0.6 s") == (sensor.axis in axes)
        assert f"{sensor.axis} (refused: status)" in status.why or sensor.axis not in axes
    assert homed.result(number).outcome == "fault"
    with pytest.raises(NotReady, match="cannot acknowledge: blind"):
        homed.acknowledge()
    assert homed.machine.rig is not None
    for axis in axes:
        homed.machine.rig.chips[axis].faults.clear()
    sleep_s(homed.clock, 0.1)
    homed.acknowledge()
    homed.power_off()
    homed.power_on()
    homed.home()
    assert homed.status().blind_s is None


def test_a_blindness_that_stays_has_a_way_out(homed: Controller, write_job) -> None:
    homed.submit(write_job())
    sleep_s(homed.clock, 3.0)
    blind_one(homed)
    sleep_s(homed.clock, 1.0)
    assert homed.status().state == "fault"
    homed.power_off()
    homed.acknowledge()
    assert homed.status().state == "unhomed"


def test_a_job_may_go_on_blind_with_a_warning(homed: Controller, write_job, finish) -> None:
    job = write_job()
    job.write_text(job.read_text() + "on_blind: warn\n")
    number = homed.submit(job)
    sleep_s(homed.clock, 3.0)
    blind_one(homed)
    sleep_s(homed.clock, 2.0)
    assert homed.status().state == "running"
    assert homed.status().blind_s == pytest.approx(2.0, abs=0.1)
    result = finish(homed, number)
    assert result.outcome == "done"
    assert result.warning.startswith("blind: no good reading of sensor z")


def test_a_hang_within_a_round_is_not_the_sensors_fault(
    homed: Controller, write_job, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody read for two seconds: the next round says that the controller hung, and stops."""
    homed.submit(write_job())
    sleep_s(homed.clock, 3.0)
    unread = Blindness(("x", "y", "z"), 0, 2.0, ("no new sample",) * 3)
    monkeypatch.setattr(homed._observer, "blind", lambda **_: unread)
    job, now_ns = homed.jobs.running, homed.clock.now_ns()
    assert job is not None
    with homed.condition.lock:
        homed._loop._drive(job, now_ns - ns(2.0))
        assert homed.condition.state is State.RUNNING
        homed._loop._drive(job, now_ns)
        assert homed.condition.state is State.FAULT


def test_a_job_is_not_begun_blind(homed: Controller, write_job, finish) -> None:
    blind_one(homed)
    sleep_s(homed.clock, 1.0)
    assert homed.status().state == "ready"
    result = finish(homed, homed.submit(write_job()))
    assert result.outcome == "refused"
    assert result.why.startswith("blind: ")


def test_sight_is_about_the_age_of_good_readings() -> None:
    sight = Sight(ROBOT)
    sight.restart(0)

    def told(axis: str, t_s: float, gate: Gate = Gate.GOOD) -> None:
        sight.reading(Reading(axis, round(t_s * 1e9), 0.5, 0, 9, 5.0, 1.0, 0.001, 0, gate))

    def at(t_s: float):
        return sight.blind(round(t_s * 1e9), dict)

    assert at(BLIND_S) is None  # it has just begun
    assert at(BLIND_S + 0.01).axes == ("x", "y", "z")
    for axis in "xyz":
        told(axis, 1.0)
    told("y", 1.4)
    told("z", 1.4, Gate.SIGMA)
    assert at(1.5) is None
    blind = at(1.6)
    assert (blind.axes, blind.since_ns) == (("x", "z"), 1_000_000_000)
    assert blind.instead == ("no new sample", "refused: sigma")
    told("x", 1.8)
    told("z", 1.8)
    assert at(1.89) is None
    assert at(1.91).axes == ("y",)


def test_a_pause_of_the_computer_is_not_yet_blindness() -> None:
    """The loop that looks wakes before the loop that reads the sensors; it waits a moment."""
    sight = Sight(ROBOT)
    sight.restart(0)

    def blind_at(t_s: float) -> bool:
        return sight.blind(round(t_s * 1e9), dict, bears_pauses=True) is not None

    assert not blind_at(0.05)
    assert not blind_at(BLIND_S + 3.0)  # the heartbeat allowed that
    assert not blind_at(BLIND_S + 3.05)
    assert blind_at(BLIND_S + 3.11)  # nothing came meanwhile
    for t_s in (4.0 + 0.2 * k for k in range(4)):  # a loop that is always late is no excuse
        assert blind_at(t_s + 0.01)


def test_a_reading_has_its_age_and_is_good_only_since_it_was_taken() -> None:
    clock = VirtualClock()
    sleep_s(clock, 10.0)
    loop = RangingLoop(Silent(), clock, 50.0, lambda reading: None)  # type: ignore[arg-type]
    taken_ns = clock.now_ns() - ns(0.25)
    loop.latest["y"] = Reading("y", taken_ns, 0.3, 0, 9, 10.0, 1.0, 0.002, 7, Gate.GOOD)
    assert loop.good_readings(taken_ns) == [loop.latest["y"]]
    assert loop.good_readings(taken_ns + 1) == []
    loop.latest["y"] = replace(loop.latest["y"], gate=Gate.SIGMA)
    assert loop.good_readings(0) == []
    x, y, _ = loop.status()
    assert (x.age_s, y.age_s) == (None, pytest.approx(0.25))
    assert y.health == "ok"
    sleep_s(clock, 3.0)
    assert loop.status()[1].health == "not read for 3 s"


class Silent:
    """Sensors that are well and say nothing."""

    def health(self) -> dict[str, str]:
        return dict.fromkeys("xyz", "ok")
