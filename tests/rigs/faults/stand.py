"""The test stand: controller, server and pulse process on the simulated robot in real time.

In this process, so that sensors, drives and disk can be reached; the pulse process is one of
its own, as on the robot. Does not model: two programs on one disk or bus, or the power supply.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.fakes.ranging_bench import RangingRig
from deltactl.drivers.steps.contract import Counts
from deltactl.drivers.steps.hosts import ProcessStepOutput
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.jobs.active_job import Phase
from deltactl.firmware_py.controller.jobs.feeder import LOOKAHEAD_S
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.main import SWITCH_S
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.named_files import CONFIG_FOLDER, TRAINED_FOLDER
from deltactl.firmware_py.planning.prepared import Readers
from deltactl.firmware_py.planning.process import PlanningProcess
from deltactl.foundation.errors import MotionError
from tests.rigs.faults.run_delay import waited_s

ROBOT_FILE = CONFIG_FOLDER / "zhao-2023.yaml"
NETWORK = "stand.tflite"
T_PWM_NS = 1_000_000
JOB = f"""
name: heart
robot: {ROBOT_FILE.name}
path: {{shape: heart, centre_m: [0.0, 0.0, -0.4], width_m: 0.06, turns: 40}}
timing: {{mode: together, t_pwm_s: {T_PWM_NS * 1e-9}}}
inverse_kinematics: {{kind: network, file: {NETWORK}}}
"""
CLOSED_S = 12.0
LEAST_LEFT_S = 40.0
"""A run that ends while a fault is judged is taken for one that stopped; the longest fault (a job
of 4 MB, on a busy machine) takes half of this, a new run 71 s."""
APPROACH_PLAYED_S = 2.0 * LOOKAHEAD_S
"""What is left of the way to the path, where motors step singly and closer, when the path is told
to have begun: a controller that fed late tells before the player knows by how much."""


@dataclass(frozen=True)
class StandRun:
    """One run of the job, and what the counters said when it began to follow the path."""

    number: int
    recording: Path
    path_ns: int
    start_ns: int
    base: tuple[int, int, int]
    """Counters of the output minus positions of the drives."""
    lost: Counts


class Stand:
    """A robot to be maltreated. `folder` holds job, network, socket and recordings."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.recordings = folder / "recordings"
        self.job = folder / "heart.yaml"
        self.network = folder / NETWORK
        self.job.write_text(JOB)
        self.restore_network()
        self.run: StandRun | None = None
        self._switch_s = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH_S)
        self._start()

    @property
    def bench(self) -> FakeBench:
        """Drives, button and alarm wires."""
        assert self.controller.machine.bench is not None
        return self.controller.machine.bench

    @property
    def rig(self) -> RangingRig:
        """Sensors and their bus."""
        assert self.controller.machine.rig is not None
        return self.controller.machine.rig

    @property
    def pulse_pid(self) -> int:
        """Number of the pulse process."""
        output = self.controller.machine.output
        assert isinstance(output, ProcessStepOutput)
        return output.process.pid

    @property
    def state(self) -> str:
        """The controller's state."""
        return self.controller.condition.state.value

    def waited_s(self) -> dict[str, float]:
        """How long each thread, of the pulse process too, has waited for a core so far."""
        return waited_s(os.getpid(), self.pulse_pid)

    def restore_network(self) -> None:
        """Put the model file (back) in its place."""
        shutil.copy(TRAINED_FOLDER / "zhao-2023.tflite", self.network)

    def restart(self) -> None:
        """End everything and start anew, as the service manager would."""
        self.close()
        sys.setswitchinterval(SWITCH_S)
        self._start()

    def close(self) -> None:
        """End server, controller and pulse process."""
        self.server.close()
        self.controller.close()
        self.planning.close()
        self.run = None
        sys.setswitchinterval(self._switch_s)

    def ensure_running(self) -> StandRun:
        """The run that is on its path with time to spare, or a new one, homed before."""
        if self.run is not None and (self.controller.status().seconds_left or 0.0) < LEAST_LEFT_S:
            self.end_run()
        if self.run is None or self.controller.condition.state is not State.RUNNING:
            self.make_ready()
            self.run = self._begin()
        return self.run

    def end_run(self) -> None:
        """Cancel the run and wait for its end."""
        if self.controller.condition.state is State.RUNNING:
            self.controller.cancel()
            wait_for(lambda: self.controller.condition.state is not State.RUNNING, 5.0)
        if self.run is not None:
            self.result_of(self.run)
        self.run = None

    def result_of(self, run: StandRun) -> JobResult | None:
        """How a run ended; its recording may be closed a while after the robot has stopped."""
        wait_for(lambda: self.controller.result(run.number) is not None, CLOSED_S)
        return self.controller.result(run.number)

    def _start(self) -> None:
        self.planning = PlanningProcess()
        self.controller: Controller = build_controller(
            ROBOT_FILE,
            simulated=True,
            realtime=True,
            recordings=self.recordings,
            readers=Readers(self.planning.prepare, self.planning.read_robot),
        )
        self.socket = self.folder / "d.sock"
        self.server = Server(
            self.controller, Listener(self.socket), self.folder / "jobs", self.recordings
        )
        self.server.start()

    def make_ready(self) -> None:
        """Switched on and homed, whatever came before."""
        controller = self.controller
        latched = controller.condition.state in (State.STOPPED, State.FAULT)
        if controller.condition.state is not State.OFF:
            controller.power_off()  # the simulated arms are put back against their stops
        if latched:
            controller.acknowledge()
        else:
            controller.power_on()
        controller.home()

    def _begin(self) -> StandRun:
        controller = self.controller
        positions = np.array(self.bench.counts())
        base = np.array(controller.machine.output.status().counts) - positions
        lost, start_ns = self.bench.memory.lost(), time.monotonic_ns()
        number = controller.submit(self.job)
        wait_for(self._on_path, 15.0)
        status = controller.status()
        if status.recording is None:
            raise MotionError(
                f"the run did not begin: {status.state} ({status.why}), {controller.result(number)}"
            )
        recording = Path(status.recording)
        time.sleep(APPROACH_PLAYED_S)
        first, second, third = base.tolist()
        path_ns = time.monotonic_ns()
        return StandRun(number, recording, path_ns, start_ns, (first, second, third), lost)

    def _on_path(self) -> bool:
        job = self.controller.jobs.running
        return job is not None and job.phase is Phase.PATH


def wait_for(condition: Callable[[], bool], limit_s: float) -> float | None:
    """Seconds until it holds; None when it does not within the limit."""
    start_s = time.monotonic()
    while not condition():
        if time.monotonic() - start_s > limit_s:
            return None
        time.sleep(0.005)
    return time.monotonic() - start_s
