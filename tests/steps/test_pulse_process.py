"""The pulse process when things go wrong: killed, frozen, orphaned, or never started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from mmap import mmap
from pathlib import Path

import numpy as np
import pytest

from deltactl.drivers.fakes.bench import SimulatedSteps, simulated_step_output
from deltactl.drivers.fakes.lines import BENCH_BYTES, BenchMemory
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.build import build_step_output
from deltactl.drivers.steps.contract import OutputState, Ticks
from deltactl.drivers.steps.hosts import ProcessStepOutput, last_counts
from deltactl.foundation.clock import RealClock, VirtualClock
from deltactl.foundation.errors import ConfigError, MissingFile, PulseFault
from tests.steps.step_rig import SAFE, SWITCHES

ROOT = Path(__file__).resolve().parents[2]
STEPS, INPUTS = StepSettings(heartbeat_s=0.1), InputSettings()
ANSWERS_S, NOTICED_S = 2.0, 4.0
"""A pulse process that is frozen is waited for so long, and taken for dead so soon: twice what the
limits say, as this machine may be busy."""


def ticks(count: int, period_ns: int = 500_000) -> Ticks:
    due_ns = time.monotonic_ns() + 10_000_000 + period_ns * np.arange(count)
    return Ticks(due_ns, np.ones((count, 3), dtype=np.int8))


def wait(until: Callable[[], bool], limit_s: float = 30.0) -> None:
    give_up_s = time.monotonic() + limit_s
    while not until():
        assert time.monotonic() < give_up_s
        time.sleep(0.002)


@pytest.fixture
def made() -> Iterator[SimulatedSteps]:
    made = simulated_step_output(STEPS, INPUTS, RealClock(), realtime=True)
    yield made
    made.close()


def process_of(made: SimulatedSteps) -> ProcessStepOutput:
    assert isinstance(made.output, ProcessStepOutput)
    return made.output


def test_a_killed_pulse_process_is_noticed_and_its_counters_kept(made: SimulatedSteps) -> None:
    output = process_of(made)
    output.enable()
    output.push(ticks(4000))
    wait(lambda: output.status().counts[0] > 20)
    os.kill(output.process.pid, signal.SIGKILL)
    wait(lambda: output.status().state is OutputState.STOPPED)
    assert output.status().reason == "the pulse process ended (signal 9)"
    with pytest.raises(PulseFault, match=r"signal 9.*home"):
        output.push(ticks(1))
    with pytest.raises(PulseFault, match="signal 9"):
        output.acknowledge()
    output.stop("must not hang")
    assert abs(output.status().counts[0] - made.bench.counts()[0]) <= 1
    assert len(output.take_sent()) == output.status().counts[0]


def test_a_frozen_pulse_process_is_given_up_and_does_not_wake_to_move(
    made: SimulatedSteps,
) -> None:
    output = process_of(made)
    output.enable()
    output.push(ticks(8000))
    wait(lambda: output.status().counts[0] > 20)
    os.kill(output.process.pid, signal.SIGSTOP)
    counts, frozen_s = made.bench.counts(), time.monotonic()
    with pytest.raises(PulseFault, match="does not answer"):
        output.disable()
    assert time.monotonic() - frozen_s < ANSWERS_S
    wait(lambda: output.status().reason == "the pulse process hangs")
    assert time.monotonic() - frozen_s < NOTICED_S
    os.kill(output.process.pid, signal.SIGCONT)
    time.sleep(0.1)
    assert made.bench.counts()[0] - counts[0] <= 1


def test_estop_to_last_edge_takes_five_milliseconds_at_most(made: SimulatedSteps) -> None:
    output = process_of(made)
    output.enable()
    latency_ns = []
    for _ in range(20):
        output.push(ticks(2000, 200_000))
        time.sleep(0.02)
        pressed_ns = time.monotonic_ns()
        made.bench.press_estop()
        wait(lambda: output.status().state is OutputState.STOPPED)
        latency_ns.append(output.take_sent().due_ns[-1] - pressed_ns)
        made.bench.release_estop()
        output.acknowledge()
        output.enable()
    assert sorted(latency_ns)[-2] <= 5_000_000


def test_where_the_motors_were_outlives_the_bench(made: SimulatedSteps) -> None:
    made.output.enable()
    made.output.push(ticks(20))
    wait(lambda: not made.output.status().queued)
    made.close()
    made.close()
    assert made.bench.counts() == made.output.status().counts == (20, 20, 20)
    assert made.bench.counts_at(0) == (0, 0, 0)


def test_needs_the_real_clock() -> None:
    with pytest.raises(ConfigError, match="real time"):
        simulated_step_output(STEPS, INPUTS, VirtualClock(), realtime=True)


def test_without_a_chip_one_line_says_so() -> None:
    with pytest.raises(PulseFault, match=r"dev/gpiochip9 does not exist|lgpio is missing"):
        build_step_output(StepSettings(chip=9), INPUTS, RealClock())


def test_no_counters_where_there_is_no_board(tmp_path: Path) -> None:
    with pytest.raises(MissingFile, match="no step counters"):
        last_counts(tmp_path / "board")


CONTROLLER = textwrap.dedent("""
    import sys, time, threading
    from pathlib import Path
    import numpy as np
    from deltactl.drivers.settings import InputSettings, StepSettings
    from deltactl.drivers.fakes.bench import simulated_step_output
    from deltactl.drivers.steps.contract import Ticks
    from deltactl.foundation.clock import RealClock
    from tests.steps.step_rig import SWITCHES

    made = []
    def build():  # in a thread that ends: its end must not be taken for the controller's
        made.append(simulated_step_output(
            StepSettings(heartbeat_s=float(sys.argv[2])), InputSettings(), RealClock(),
            realtime=True, board_path=Path(sys.argv[1]), switches=SWITCHES))
    thread = threading.Thread(target=build); thread.start(); thread.join()
    output = made[0].output
    output.enable()
    output.switch(*SWITCHES.levels({"gripper": True, "valve": True, "brake": False}))
    due = time.monotonic_ns() + 10_000_000 + 1_000_000 * np.arange(8000)
    output.push(Ticks(due, np.ones((8000, 3), dtype=np.int8)))
    print(output.process.pid, made[0].bench.descriptor, flush=True)
    while True:
        output.beat()
        status = output.status()
        if status.reason:
            print(status.reason, *status.counts, *made[0].bench.counts(), flush=True)
            made[0].close()
            break
        time.sleep(0.005)
""")


class Controller:
    """A controller in a process of its own, to be killed."""

    def __init__(self, board: Path, heartbeat_s: float):
        self.board = board
        self.process = subprocess.Popen(
            [sys.executable, "-c", CONTROLLER, str(board), str(heartbeat_s)],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        pulse_pid, bench = self.process.stdout.readline().split()
        self.pulse_pid = int(pulse_pid)
        with Path(f"/proc/{self.process.pid}/fd/{bench}").open("r+b") as shared:
            self.drives = BenchMemory(mmap(shared.fileno(), BENCH_BYTES))
        wait(lambda: last_counts(board)[0] > 20)

    def outputs(self) -> dict[str, bool]:
        """What hangs on the outputs, whoever lives."""
        return SWITCHES.states(self.drives.switched)

    def pulses_run(self) -> bool:
        try:
            os.kill(self.pulse_pid, 0)
        except ProcessLookupError:
            return False
        return "Z" not in Path(f"/proc/{self.pulse_pid}/stat").read_text().rsplit(")")[1][:3]

    def word(self, index: int) -> int:
        return memoryview(self.board.read_bytes()[: b.WORDS * 8]).cast("q")[index]

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[[float], Controller]]:
    started: list[Controller] = []

    def begin(heartbeat_s: float) -> Controller:
        started.append(Controller(tmp_path / "board", heartbeat_s))
        return started[-1]

    yield begin
    for controller in started:
        controller.end()


def test_pulses_end_with_a_killed_controller_and_the_counters_stay(
    start: Callable[[float], Controller],
) -> None:
    controller = start(5.0)  # so that it is not the heartbeat that stops
    folder = Path(f"/proc/{controller.pulse_pid}/cwd").readlink()
    assert folder.name.startswith("deltactl-pulses-")
    controller.process.kill()
    wait(lambda: not controller.pulses_run())
    assert controller.word(b.STATE) == b.STOPPED
    assert controller.word(b.REASON) == b.CONTROLLER_GONE
    counts = last_counts(controller.board)
    assert counts[0] == counts[1] == counts[2] > 20
    time.sleep(0.05)
    assert last_counts(controller.board) == counts
    assert not folder.exists()


def test_outputs_that_are_on_become_safe_when_the_controller_is_killed(
    start: Callable[[float], Controller],
) -> None:
    """A gripper that holds, an open valve: the pulse process outlives the daemon for that."""
    controller = start(5.0)
    assert controller.outputs() == {"gripper": True, "valve": True, "brake": False}
    controller.process.kill()
    wait(lambda: not controller.pulses_run())
    assert controller.outputs() == SAFE


def test_a_frozen_controller_loses_its_heartbeat(start: Callable[[float], Controller]) -> None:
    controller = start(0.1)
    os.kill(controller.process.pid, signal.SIGSTOP)
    counts = last_counts(controller.board)
    wait(lambda: controller.word(b.STATE) == b.STOPPED)
    assert controller.word(b.REASON) == b.NO_HEARTBEAT
    ran_on = last_counts(controller.board)[0] - counts[0]
    assert ran_on <= 100 + 10  # one step each millisecond for as long as the heartbeat lasts
    os.kill(controller.process.pid, signal.SIGCONT)
    said, _ = controller.process.communicate(timeout=10)
    final = last_counts(controller.board)
    assert said.split() == ["no", "heartbeat", *map(str, final), *map(str, final)]


def test_ctrl_c_and_sigterm_are_the_controllers_affair(
    start: Callable[[float], Controller],
) -> None:
    controller = start(5.0)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(controller.pulse_pid, number)
    before = last_counts(controller.board)[0]
    wait(lambda: last_counts(controller.board)[0] > before + 50)
