"""Where the tests run: on a modelled Pi below the system calls, or (--hardware) on this one."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from deltactl.drivers.fakes.syscall_trap import available
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER, find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import DeltactlError
from tests.rigs import needs
from tests.rigs.hil.modelled_pi import ModelledPi

JOB = """
name: heart
robot: {robot}
path: {{shape: heart, centre_m: [0.0, 0.0, -0.4], width_m: {width_m}, turns: {turns}}}
timing: {{mode: together, t_pwm_s: {t_pwm_s}}}
inverse_kinematics: {{kind: network, file: zhao-2023.tflite}}
"""
T_PWM_S = 0.002
SHIPPED_T_PWM_S = 0.003
"""Of the shipped heart here: half of what its file says."""
START_S = 30.0


@dataclass
class Site:
    """A daemon on its robot. `pi` is the modelled machine, None on a real one."""

    robot_file: Path
    folder: Path
    executable: str
    pi: ModelledPi | None
    may_move: bool
    process: subprocess.Popen[bytes]

    @property
    def socket(self) -> Path:
        return self.folder / "d.sock"

    def client(self) -> Client:
        return Client(self.socket)

    def job(self, width_m: float = 0.03, turns: int = 1) -> Path:
        path = self.folder / "heart.yaml"
        text = JOB.format(robot=self.robot_file, width_m=width_m, turns=turns, t_pwm_s=T_PWM_S)
        path.write_text(text)
        return path

    def shipped_heart(self) -> Path:
        """config/heart.yaml, in half its time."""
        text = (CONFIG_FOLDER / "heart.yaml").read_text()
        text = re.sub("^robot: .*$", f"robot: {self.robot_file}", text, flags=re.MULTILINE)
        path = self.folder / "shipped.yaml"
        path.write_text(re.sub(r"t_pwm_s: [\d.]+", f"t_pwm_s: {SHIPPED_T_PWM_S}", text))
        return path

    def home(self, client: Client) -> None:
        """From any state to READY, with the arms where the operator has put them."""
        state = client.status().state
        if state != "off":
            client.power_off()
        if self.pi is not None:
            self.pi.put_to_stops()
        if state in ("stopped", "fault"):
            client.acknowledge()
        else:
            client.power_on()
        client.home()

    def run(self, client: Client, job: Path, limit_s: float = 30.0) -> JobResult:
        number = client.submit(job)
        wait_for(lambda: client.result(number) is not None, limit_s)
        result = client.result(number)
        assert result is not None
        return result

    def log(self) -> str:
        return (self.folder / "log").read_text()


def wait_for(condition: Callable[[], bool], limit_s: float) -> float:
    """Seconds until it holds; fails when it does not come to hold."""
    start_s = time.monotonic()
    while not condition():
        assert time.monotonic() - start_s < limit_s, f"not within {limit_s:g} s"
        time.sleep(0.01)
    return time.monotonic() - start_s


@pytest.fixture(
    scope="module",
    params=["modelled", pytest.param("hardware", marks=pytest.mark.hardware)],
)
def site(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Site]:
    """One daemon for all tests of a file, as systemd would start it."""
    pytest.importorskip("lgpio", reason=needs.LGPIO, exc_type=ImportError)
    hardware = request.param == "hardware"
    if not hardware and not available():
        pytest.skip("needs seccomp user notification (Linux 5.14 or newer, x86-64 or ARM64)")
    folder = tmp_path_factory.mktemp("hil")
    robot_file = find(request.config.getoption("--robot"))
    pi = None if hardware else ModelledPi(load_robot(robot_file))
    executable = sys.executable if pi is None else pi.executable
    places = ["--recordings", str(folder / "recordings"), "--socket", str(folder / "d.sock")]
    with (folder / "log").open("wb") as log:
        process = subprocess.Popen(
            [executable, "-m", "deltactl.cli.main", "service", "daemon", str(robot_file), *places],
            cwd=folder,
            env=os.environ | {"STATE_DIRECTORY": str(folder / "state")},
            stderr=log,
        )
    may_move = not hardware or bool(request.config.getoption("--move"))
    made = Site(robot_file, folder, executable, pi, may_move, process)
    try:
        wait_for(lambda: made.socket.exists() or process.poll() is not None, START_S)
        assert process.poll() is None, made.log()
        yield made
    finally:
        process.terminate()
        try:
            process.wait(15.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if pi is not None:
            pi.close()


@pytest.fixture
def client(site: Site) -> Iterator[Client]:
    """A connection to the daemon; whatever ran is stopped afterwards."""
    with site.client() as made:
        yield made
        if made.status().state in ("running", "paused"):
            made.stop("the test has ended")


@pytest.fixture
def moving_site(site: Site) -> Site:
    """The site, where the robot may move."""
    if not site.may_move:
        pytest.skip("moves the robot: run with --hardware --move")
    return site


@pytest.fixture
def pi(site: Site) -> ModelledPi:
    """The modelled machine: for tests that need a hand on the button or a broken wire."""
    if site.pi is None:
        pytest.skip("needs hands on the robot: only on the modelled Pi")
    return site.pi


@pytest.fixture
def running(moving_site: Site, pi: ModelledPi, client: Client) -> Client:
    """On the path of a long job, with the arms moving."""
    moving_site.home(client)
    client.submit(moving_site.job(0.08, 20))
    wait_for(lambda: client.status().state == "running", 10.0)
    wait_for(lambda: client.status().progress > 0.0, 10.0)
    before = pi.bench.counts()
    wait_for(lambda: pi.bench.counts() != before, 10.0)
    return client


def refused(ask: Callable[[], object]) -> str:
    """The words with which a request is refused."""
    with pytest.raises(DeltactlError) as caught:
        ask()
    return str(caught.value)
