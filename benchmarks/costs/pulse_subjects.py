"""The ways of making pulses that benchmarks/costs/pulse.py compares, each in its own process.

`python benchmarks/costs/pulse_subjects.py METHOD PERIOD_US SECONDS`: makes pulses for three motors
while a second Python thread of the process computes, then prints what it knows as JSON.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from deltactl.drivers.fakes.bench import simulated_step_output
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.build import build_step_output
from deltactl.drivers.steps.contract import OutputState, StepOutput, Ticks
from deltactl.drivers.steps.hosts import ProcessStepOutput
from deltactl.foundation.clock import RealClock

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

    from deltactl.drivers.pin_factory import lgpio_pin_factory

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
    one = [lgpio.pulse(7, 7, width_us), lgpio.pulse(0, 7, round(period_us) - width_us)]
    lgpio.tx_wave(handle, PULSE.step_pins[0], one * count)
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


def main(method: str, period_us: str, seconds: str) -> None:
    """Run one method beside a busy thread, and print what it knows."""
    if method != "ruler":
        threading.Thread(target=compute_for_ever, daemon=True).start()
    facts = METHODS[method](float(period_us), float(seconds))
    print(json.dumps(facts), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:4])
