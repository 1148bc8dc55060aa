"""How punctual are the pulses? Both backends and their peers, in one run on this machine.

`python benchmarks/costs/pulse.py [--seconds 1.0]`. Every way of making pulses runs in a process of
its own (`pulse.py METHOD PERIOD_US SECONDS`) beside a busy Python thread. Where lgpio is in play,
the real library runs on a modelled GPIO chip (drivers/fakes/syscall_trap.py), which takes the time
when a write arrives, and which makes every call slower than a real one. No real line is touched.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import platform
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.drivers.fakes.bench import simulated_step_output
from deltactl.drivers.fakes.gpio_chip import GpioChip
from deltactl.drivers.fakes.syscall_trap import Device, SyscallTrap, available
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import build_step_output
from deltactl.drivers.steps.contract import OutputState, StepOutput, Ticks
from deltactl.drivers.steps.hosts import ProcessStepOutput
from deltactl.foundation.clock import RealClock, VirtualClock, sleep_s

INPUTS = InputSettings()
PULSE, PINS = StepSettings(), StepSettings(backend="gpiozero")
Facts = dict[str, Any]


def compute_for_ever() -> None:
    """What else goes on in the interpreter: inverse kinematics, a recorder, a status client."""
    total = 0
    while True:
        total += sum(range(1000))


def play(output: StepOutput, period_us: float, seconds: float) -> Facts:
    """Push ticks as a controller does, until all are sent."""
    output.enable()
    count = round(seconds * 1e6 / period_us)
    start_ns = time.monotonic_ns() + 20_000_000
    due_ns = start_ns + np.round(period_us * 1000 * np.arange(count)).astype(np.int64)
    done = 0
    while done < count or output.status().queued:
        some = slice(done, done + min(output.room(), count - done))
        output.push(Ticks(due_ns[some], np.ones((some.stop - done, 3), dtype=np.int8)))
        done = some.stop
        output.beat()
        time.sleep(0.02)
    status = output.status()
    return {
        "sent": status.counts[0],
        "asked": count,
        "slip_us": status.slip_ns / 1000,
        "granted": output.realtime if isinstance(output, ProcessStepOutput) else "",
    }


def on_the_bench(settings: StepSettings, period_us: float, seconds: float) -> Facts:
    """A backend on the fake bench; the simulated drives say when their edges came."""
    made = simulated_step_output(settings, INPUTS, RealClock(), realtime=True)
    facts = play(made.output, period_us, seconds)
    rows_per_step = 1 if settings.backend == "pulse" else 3
    times_ns = made.bench.memory.step_times()[::rows_per_step]
    facts |= {"times_ns": times_ns, "lost": sum(made.bench.memory.lost())}
    made.close()
    return facts


def on_lgpio(settings: StepSettings, period_us: float, seconds: float) -> Facts:
    """A backend on lgpio; the chip says when its edges came."""
    output = build_step_output(settings, INPUTS, RealClock())
    facts = play(output, period_us, seconds)
    output.close()
    return facts


def blink(period_us: float, seconds: float) -> Facts:
    """gpiozero as its recipes use it: on, off, sleep until the next absolute time, in a thread."""
    from gpiozero import OutputDevice

    from deltactl.drivers.steps.lgpio_pins import lgpio_pin_factory

    factory = lgpio_pin_factory(PULSE.chip)
    pins = [OutputDevice(pin, pin_factory=factory) for pin in PULSE.step_pins]
    count, sent = round(seconds * 1e6 / period_us), 0

    def body() -> None:
        nonlocal sent
        start_s = time.monotonic() + 0.02
        for index in range(count):
            if time.monotonic() > start_s + 2.0 * seconds:
                return
            sent += 1
            time.sleep(max(0.0, start_s + index * period_us * 1e-6 - time.monotonic()))
            for pin in pins:
                pin.on()
            for pin in pins:
                pin.off()

    thread = threading.Thread(target=body)
    thread.start()
    thread.join()
    return {"sent": sent, "asked": count}


def wave(period_us: float, seconds: float) -> Facts:
    """lgpio's own waves, all motors in one group."""
    import lgpio

    handle = lgpio.gpiochip_open(0)
    lgpio.group_claim_output(handle, list(PULSE.step_pins))
    count = round(seconds * 1e6 / period_us)
    width_us = round(PULSE.pulse_width_us)
    pulses = [lgpio.pulse(7, 7, width_us), lgpio.pulse(0, 7, round(period_us) - width_us)]
    lgpio.tx_wave(handle, PULSE.step_pins[0], pulses * count)
    while lgpio.tx_busy(handle, PULSE.step_pins[0], lgpio.TX_WAVE):
        time.sleep(0.02)
    return {"sent": count, "asked": count}


def estop(period_us: float, seconds: float) -> Facts:
    """From the press of the button to the last edge, over and over."""
    made = simulated_step_output(PULSE, INPUTS, RealClock(), realtime=True)
    output, latencies_ns = made.output, []
    output.enable()
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        start_ns = time.monotonic_ns() + 10_000_000
        due_ns = start_ns + round(period_us * 1000) * np.arange(1000)
        output.push(Ticks(due_ns, np.ones((1000, 3), dtype=np.int8)))
        time.sleep(0.015)
        pressed_ns = time.monotonic_ns()
        made.bench.press_estop()
        while output.status().state is not OutputState.STOPPED:
            time.sleep(0.001)
        latencies_ns.append(max(0, int(output.take_sent().due_ns[-1]) - pressed_ns))
        made.bench.release_estop()
        output.acknowledge()
        output.enable()
    made.close()
    return {"latencies_ns": latencies_ns}


def ruler(period_us: float, seconds: float) -> Facts:
    """How long a write takes, spaced as pulses are."""
    import lgpio

    handle, calls_ns = lgpio.gpiochip_open(0), []
    lgpio.group_claim_output(handle, list(PULSE.step_pins))
    for turn in range(round(seconds * 1000)):
        time.sleep(0.0005)
        before_ns = time.monotonic_ns()
        lgpio.group_write(handle, PULSE.step_pins[0], 7 * (turn & 1), 7)
        calls_ns.append(time.monotonic_ns() - before_ns)
    return {"calls_ns": calls_ns}


METHODS: dict[str, Callable[[float, float], Facts]] = {
    "pulse-fake": lambda period_us, seconds: on_the_bench(PULSE, period_us, seconds),
    "pulse-lgpio": lambda period_us, seconds: on_lgpio(PULSE, period_us, seconds),
    "gpiozero-mock": lambda period_us, seconds: on_the_bench(PINS, period_us, seconds),
    "gpiozero-lgpio": lambda period_us, seconds: on_lgpio(PINS, period_us, seconds),
    "blink": blink,
    "wave": wave,
    "estop": estop,
    "ruler": ruler,
}


def be_a_subject(method: str, period_us: str, seconds: str) -> None:
    """Run one method beside a busy thread, and print what it knows as JSON."""
    if method != "ruler":
        threading.Thread(target=compute_for_ever, daemon=True).start()
    facts = METHODS[method](float(period_us), float(seconds))
    print(json.dumps(facts), flush=True)


PERIODS_US = (2000, 500, 100)
REVISION = {"/proc/device-tree/system/linux,revision": bytes.fromhex("00c03111")}

ROWS: tuple[tuple[str, str, bool], ...] = (
    ("pulse process, fake lines", "pulse-fake", False),
    ("pulse process, lgpio", "pulse-lgpio", True),
    ("gpiozero backend, mock pins", "gpiozero-mock", False),
    ("gpiozero backend, lgpio", "gpiozero-lgpio", True),
    ("peer: plain gpiozero on/off in a thread", "blink", True),
    ("peer: lgpio tx_wave", "wave", True),
)
"""Name, method, and whether it needs a GPIO chip."""


def machine() -> str:
    """What this is, in one line."""
    model = Path("/proc/device-tree/model")
    kind = model.read_text().rstrip("\0") if model.exists() else f"{platform.machine()} (no Pi)"
    with contextlib.suppress(OSError, StopIteration):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        kind += ", " + next(x.split(":")[1].strip() for x in lines if x.startswith("model name"))
    load = "/".join(f"{part:.1f}" for part in os.getloadavg())
    return (
        f"{kind}, {os.cpu_count()} cores, Linux {platform.release()}, "
        f"Python {platform.python_version()}, load {load}"
    )


def run(executable: str, method: str, period_us: float, seconds: float) -> dict[str, Any] | str:
    """What a subject says, or one line on why it said nothing."""
    command = [executable, __file__, method, str(period_us), str(seconds)]
    env = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=seconds + 10, env=env, check=False
        )
    except subprocess.TimeoutExpired:
        return f"gave up after {seconds + 10:g} s"
    if done.returncode:
        return done.stderr.strip().splitlines()[-1].split(": ", 1)[-1].split(";")[0]
    facts: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return facts


class FairChip(GpioChip):
    """A chip that is not itself what is late: it answers with real-time priority."""

    def __init__(self) -> None:
        super().__init__()
        self._raised = False

    def ioctl(self, request: int, data: bytes) -> tuple[bytes, Device | None]:
        """See Device."""
        if not self._raised:
            self._raised = True
            with contextlib.suppress(OSError):  # 0 is the calling thread
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(45))
        return super().ioctl(request, data)


def on_chip(method: str, period_us: float, seconds: float) -> dict[str, Any] | str:
    """The same on a modelled chip, which notes when STEP of motor 1 rises."""
    if not available():
        return "not available here: no GPIO chip, and no seccomp user notification to model one"
    chip, times_ns = FairChip(), list[int]()
    chip.connect(
        StepSettings().step_pins[0], lambda up: times_ns.append(time.monotonic_ns()) if up else None
    )
    settings, inputs = StepSettings(), InputSettings()
    chip.drive(inputs.estop_pin or 0, False)
    for pin in settings.alarm_pins or ():
        chip.drive(pin, True)
    trap = SyscallTrap({"/dev/gpiochip0": chip}, (0xB4,), REVISION)
    try:
        facts = run(trap.executable, method, period_us, seconds)
    finally:
        trap.close()
    return facts if isinstance(facts, str) else {**facts, "times_ns": times_ns}


def row(name: str, period_us: float, facts: dict[str, Any] | str) -> str:
    """One line of the table."""
    head = f"{name:<41}{period_us:>6} "
    if isinstance(facts, str):
        return f"{head}   {facts}"
    gaps_us = np.diff(np.array(facts["times_ns"])) / 1000
    if not len(gaps_us):
        return f"{head}  no pulses seen"
    p50, p99, most = np.percentile(np.abs(gaps_us - period_us), [50, 99, 100])
    pulses = len(gaps_us) + 1
    count = "exact" if pulses == facts["asked"] == facts["sent"] else f"{pulses}/{facts['asked']}"
    lost = facts.get("lost")
    drives = "-" if lost is None else str(lost)
    return f"{head}{p50:>9.1f}{p99:>10.1f}{most:>10.1f}{gaps_us.min():>10.1f}{count:>12}{drives:>6}"


def ruler_line() -> str:
    """What one call on the modelled chip costs, which the rows with lgpio carry with them."""
    facts = on_chip("ruler", 0.0, 0.5)
    if isinstance(facts, str):
        return f"cost of a call on the modelled chip: {facts}"
    p50, p99 = np.percentile(np.array(facts["calls_ns"]) / 1000, [50, 99])
    return f"cost of a call on the modelled chip: p50 {p50:.0f}, p99 {p99:.0f} us"


def estop_line(seconds: float) -> str:
    """From pressing the e-stop to the last edge, in the pulse process."""
    facts = run(sys.executable, "estop", 500, seconds)
    if isinstance(facts, str):
        return f"e-stop to last edge: {facts}"
    p50, p99, most = np.percentile(np.array(facts["latencies_ns"]) / 1e6, [50, 99, 100])
    return (
        f"e-stop to last edge, pulse process at 500 us: p50 {p50:.2f}, p99 {p99:.2f}, "
        f"max {most:.2f} ms over {len(facts['latencies_ns'])} presses"
        " (0: no edge at all after the press; wanted: p99 <= 5 ms)"
    )


def virtual_line() -> str:
    """How fast the same player runs on a virtual clock with simulated drives."""
    clock, count = VirtualClock(), 8000
    made = simulated_step_output(StepSettings(), InputSettings(), clock, realtime=False)
    made.output.enable()
    due_ns = clock.now_ns() + 10_000_000 + 100_000 * np.arange(count)
    start_s = time.process_time()
    made.output.push(Ticks(due_ns, np.ones((count, 3), dtype=np.int8)))
    for _ in range(100):
        made.output.beat()
        sleep_s(clock, 0.01)
    rate = count / (time.process_time() - start_s)
    moved = made.bench.counts()[0]
    made.close()
    return f"virtual clock: {rate:,.0f} ticks a second of three motors ({moved} of {count} arrived)"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=1.0, help="length of each measurement")
    seconds = parser.parse_args().seconds
    print(f"machine: {machine()}")
    print(f"{'':<41}{'':>6} {'period error, us':^29}{'smallest':>10}")
    print(
        f"{'(busy Python thread beside each)':<41}{'us':>6} {'p50':>9}{'p99':>10}{'max':>10}"
        f"{'gap, us':>10}{'pulses':>12}{'lost':>6}"
    )
    granted = ""
    for name, method, needs_chip in ROWS:
        for period_us in PERIODS_US:
            measure = on_chip if needs_chip else (lambda *what: run(sys.executable, *what))
            facts = measure(method, period_us, seconds)
            print(row(name, period_us, facts), flush=True)
            if not isinstance(facts, str):
                granted = facts.get("granted") or granted
    print(f"granted to the pulse process: {granted}")
    print(ruler_line())
    print(estop_line(2 * seconds))
    print(virtual_line())


if __name__ == "__main__":
    if sys.argv[1:2] and sys.argv[1] in METHODS:
        be_a_subject(*sys.argv[1:])
    else:
        main()
