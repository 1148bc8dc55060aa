"""The daemon and its pulse process over unmodified smbus2, gpiozero and lgpio.

Here on a modelled Pi; on a real one with `pytest -m hil --hardware`, which moves nothing
without `--move`.
"""

from __future__ import annotations

import json
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from deltactl.drivers.fakes.gpio_chip import SET_VALUES
from deltactl.drivers.fakes.i2c_bus import I2C_RDWR
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.robot_file import load_robot
from deltactl.firmware_py.run_report.tracking import robot_of, track
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.reading.reader import read_run
from tests.rigs.hil.modelled_pi import ModelledPi

from .conftest import SHIPPED_T_PWM_S, T_PWM_S, Site, refused, wait_for

pytestmark = pytest.mark.hil
TURNS_WHILE_PLANNED = 10
SHIPPED_S = 600.0
"""At most, for a heart of 16 s: on an emulated processor the models are slow."""


def test_it_waits_switched_off_with_idle_inputs(site: Site, client: Client) -> None:
    """An open e-stop or a tripped drive would be seen within a millisecond."""
    time.sleep(0.3)
    status = client.status()
    assert (status.state, status.why, status.simulated) == ("off", "", False)
    assert "cannot run: the robot is off" in refused(lambda: client.submit(site.job()))


@pytest.mark.study
def test_the_shipped_heart_over_the_real_ioctl_path(moving_site: Site, client: Client) -> None:
    """config/heart.yaml, 20 cm wide, in half its time."""
    site = moving_site
    site.home(client)
    before = site.pi.bench.counts() if site.pi else (0, 0, 0)
    home = np.array(client.status().counts)
    if site.pi:
        site.pi.adapter.calls.clear()
        site.pi.gpio.calls.clear()
    result = site.run(client, site.shipped_heart(), SHIPPED_S)
    assert (result.outcome, result.why, result.recording_error) == ("done", "", "")
    commanded = client.status().counts
    run = read_run(Path(result.recording or ""))
    assert run.complete
    assert tuple(run.edges.counts[-1]) == commanded == tuple(run.targets.steps[-1])
    assert min(readings.good.sum() for readings in run.readings.values()) > 50
    measured = track(run, robot_of(run)).measured
    assert measured is not None
    assert max(measured.rms_m) < 0.003  # noise of 1.5 mm
    path_ns = next(event.t_ns for event in run.events if event.kind == "path_start")
    gaps_ns = np.diff(run.edges.t_ns[run.edges.t_ns > path_ns + 50_000_000])
    least = load_robot(site.robot_file).steps.minimum_gap_fraction
    assert gaps_ns.min() >= least * SHIPPED_T_PWM_S * 1e9 - 1_000
    if site.pi:
        moved = np.array(site.pi.bench.counts()) - before
        assert tuple(home + moved) == commanded
        assert site.pi.bench.memory.lost() == (0, 0, 0)
        assert site.pi.adapter.calls[I2C_RDWR] > 3 * 2 * 50 * 15  # three sensors, 50 Hz, 15 s
        assert site.pi.gpio.calls[SET_VALUES] >= 2 * len(run.edges.t_ns) - 2


def test_a_large_job_changes_no_pulse_of_a_run(
    moving_site: Site, pi: ModelledPi, client: Client
) -> None:
    """It is parsed and planned elsewhere: every pulse goes out, and no heartbeat is missed."""
    site = moving_site
    poses = ",".join(f"[{30 + n % 7}.125, 31.{n:06d}, 32.25]" for n in range(5_000))
    large = site.folder / "large.yaml"
    large.write_text(
        f"name: large\nrobot: {site.robot_file}\ninverse_kinematics: {{kind: geometry}}\n"
        f"timing: {{mode: together, t_pwm_s: 0.001}}\n"
        f"path: {{shape: joints, angles_deg: [{poses}]}}\n"
    )
    site.home(client)
    before, home = np.array(pi.bench.counts()), np.array(client.status().counts)
    # On a slow machine the large job is planned late, and must not begin before it is cancelled.
    number = client.submit(site.job(0.015, turns=TURNS_WHILE_PLANNED))
    with site.client() as other:
        other.cancel(other.submit(large))
    assert client.result(number) is None
    wait_for(lambda: client.result(number) is not None, 60.0)
    result = client.result(number)
    assert result is not None
    assert (result.outcome, result.why, result.recording_error) == ("done", "", "")
    run = read_run(Path(result.recording or ""))
    assert tuple(run.edges.counts[-1]) == tuple(run.targets.steps[-1]) == client.status().counts
    assert tuple(home + np.array(pi.bench.counts()) - before) == client.status().counts
    assert pi.bench.memory.lost() == (0, 0, 0)
    path_ns = next(event.t_ns for event in run.events if event.kind == "path_start")
    gaps_ns = np.diff(run.edges.t_ns[run.edges.t_ns > path_ns + 50_000_000])
    least = load_robot(site.robot_file).steps.minimum_gap_fraction
    assert gaps_ns.min() >= least * T_PWM_S * 1e9 - 1_000


def test_the_e_stop_ends_the_pulses(running: Client, pi: ModelledPi) -> None:
    pressed_ns = time.monotonic_ns()
    pi.bench.press_estop()
    wait_for(lambda: running.status().state == "stopped", 2.0)
    last_ns = pi.bench.memory.step_times()[-1]
    assert last_ns - pressed_ns < 50_000_000  # 5 ms are promised without the models beside
    assert running.status().why == "e-stop"
    assert "release the button" in refused(running.acknowledge)
    pi.bench.release_estop()
    time.sleep(0.1)
    assert pi.bench.memory.step_times()[-1] == last_ns
    running.acknowledge()
    assert running.status().state == "unhomed"


def test_a_drive_alarm_stops_and_names_the_motor(
    running: Client, pi: ModelledPi, site: Site
) -> None:
    pi.bench.trip(2)
    wait_for(lambda: running.status().state == "fault", 2.0)
    assert running.status().why == "alarm motor2"
    assert "motor2" in refused(running.acknowledge)
    running.power_off()  # releasing a drive clears its alarm, but not the latch
    assert running.status().state == "fault"
    site.home(running)
    assert running.status().state == "ready"


def test_a_brown_out_restarts_one_sensor_while_the_robot_goes_on(
    running: Client, pi: ModelledPi
) -> None:
    samples = pi.chips["x"].samples
    pi.chips["y"].brown_out()
    wait_for(lambda: _health(running, "y").startswith("restarting"), 2.0)
    wait_for(lambda: _health(running, "y") == "ok", 3.0)
    assert pi.chips["y"].address == pi.robot.ranging.addresses[1]
    assert pi.chips["x"].samples > samples
    assert running.status().state == "running"


def test_a_bus_held_low_stops_the_robot(running: Client, pi: ModelledPi) -> None:
    """errno 110 from the ioctl, on every transfer."""
    pi.adapter.bus.stuck = True
    try:
        wait_for(lambda: running.status().state == "fault", 3.0)
    finally:
        pi.adapter.bus.stuck = False
    why = running.status().why
    assert why.startswith("blind:")
    assert why.count("errno 110") == 3
    assert "errno 110" in running.status().why
    counts = pi.bench.counts()
    time.sleep(0.1)
    assert pi.bench.counts() == counts


@pytest.mark.study
def test_sensors_are_read_without_a_daemon(site: Site, tmp_path: Path) -> None:
    """Last: the daemon has to give the lines back first."""
    site.process.terminate()
    assert site.process.wait(15.0) == 0, site.log()
    words = [
        "-m",
        "deltactl.cli.main",
        "status",
        "sensors",
        "--robot",
        str(site.robot_file),
        "--json",
    ]
    done = subprocess.run(
        [site.executable, *words], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.stderr == ""
    sensors = json.loads(done.stdout)
    assert [sensor["axis"] for sensor in sensors] == ["x", "y", "z"]
    assert {sensor["health"] for sensor in sensors} == {"ok"}
    assert all(0.0 < sensor["distance_m"] < 4.0 for sensor in sensors)


def _health(client: Client, axis: str) -> str:
    try:
        return next(sensor.health for sensor in client.sensors() if sensor.axis == axis)
    except DeltactlError as error:
        return str(error)
