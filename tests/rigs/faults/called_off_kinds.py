"""Requests that are called off, and clients that die, at random moments: nothing moves on.

Each takes a robot in real time, with the real planner and pulse process, through its socket.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from random import Random

import numpy as np

from deltactl.firmware_py.daemon.client import Client
from tests.rigs.faults.edges import after, edge_times_ns
from tests.rigs.faults.stand import ROBOT_FILE, Stand, wait_for
from tests.rigs.faults.verdict import Verdict
from tests.rigs.two_clients import Wire

LONG = f"""name: long
robot: {ROBOT_FILE.name}
path: {{shape: circle, centre_m: [0.0, 0.0, -0.45], radius_m: 0.06, turns: 400, spacing_m: 0.0004}}
timing: {{mode: accelerated, speed_mps: 0.05}}
inverse_kinematics: {{kind: geometry}}
"""
"""Its check takes seconds."""
ANSWERED_S = 0.5
"""Within so long a request that calls something off is answered, and whoever waits is told."""
SLOWED_S = 1.0
HOMING_S = 0.3
"""0.1 s of a homing may be under way when its client dies, which is seen after a while."""
QUIET_S = 1.0
CallOff = Callable[[Client], object]


def while_planning(call_off: CallOff, then: str) -> Callable[[Stand, Random, Verdict], None]:
    """A kind of fault: something calls a job off that is being planned. `then`: the state after."""

    def fault(stand: Stand, chance: Random, verdict: Verdict) -> None:
        _homed(stand)
        waiting = Wire(stand.socket)
        asked = waiting.send("run", job_text=LONG, name="long.yaml")
        planned = wait_for(lambda: stand.state == "planning", 5.0)
        verdict.demand(planned is not None, f"is {stand.state}, not planning")
        time.sleep(chance.uniform(0.0, 0.6))
        verdict.demand(stand.state == "planning", "the check is over already")
        fault_ns = time.monotonic_ns()
        with Client(stand.socket) as other:
            call_off(other)
        _reaches(stand, verdict, then, ANSWERED_S)
        verdict.demand(not waiting.answer(asked)["ok"], "who waits for the check was not told")
        waiting.close()
        stand.make_ready()
        _quiet(stand, verdict, fault_ns)

    return fault


def client_dies_planning(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """The client dies while its job is planned; another of its jobs would be next."""
    _homed(stand)
    waiting = Wire(stand.socket)
    for _ in range(2):
        waiting.send("run", job_text=LONG, name="long.yaml")
    wait_for(lambda: stand.state == "planning", 5.0)
    time.sleep(chance.uniform(0.0, 0.6))
    fault_ns = time.monotonic_ns()
    waiting.close()
    _reaches(stand, verdict, "ready", ANSWERED_S)
    _quiet(stand, verdict, fault_ns)


def held_planning(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """A pause while a job is planned holds it beyond its check; then it is cancelled."""
    _homed(stand)
    with Client(stand.socket) as owner, Client(stand.socket) as other:
        submitting = threading.Thread(target=lambda: owner.submit(stand.job))
        submitting.start()
        wait_for(lambda: stand.state == "planning", 5.0)
        paused_ns = time.monotonic_ns()
        other.pause()
        submitting.join(10.0)
        _quiet(stand, verdict, paused_ns)
        verdict.demand(stand.state == "paused", f"is {stand.state}, not paused")
        other.cancel()
        _reaches(stand, verdict, "ready", ANSWERED_S)
        _quiet(stand, verdict, paused_ns)


def client_dies_running(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """The client dies in the middle of its job, with another one queued."""
    _homed(stand)
    lost_before = np.array(stand.bench.memory.lost())
    with Client(stand.socket) as client:
        numbers = [client.submit(stand.job), client.submit(stand.job)]
        wait_for(lambda: stand.state == "running", 5.0)
        time.sleep(chance.uniform(0.5, 1.5))
        fault_ns = time.monotonic_ns()
    _reaches(stand, verdict, "ready", SLOWED_S + 1.0)
    edges_ns = edge_times_ns(stand.bench.memory)
    verdict.last_edge_s = max(0.0, (int(edges_ns[-1]) - fault_ns) * 1e-9)
    late = f"last edge {verdict.last_edge_s:.2f} s after"
    verdict.demand(verdict.last_edge_s < SLOWED_S, late)
    lost = np.array(stand.bench.memory.lost()) - lost_before
    verdict.demand(not lost.any(), f"it did not slow down: the drives lost {lost}")
    # A result is there once its recording is closed, which the state does not wait for.
    wait_for(lambda: all(stand.controller.result(number) for number in numbers), 5.0)
    outcomes = [stand.controller.result(number) for number in numbers]
    cancelled = all(one is not None and one.outcome == "cancelled" for one in outcomes)
    verdict.demand(cancelled, f"results {outcomes}")
    _quiet(stand, verdict, time.monotonic_ns())


def client_dies_homing(stand: Stand, chance: Random, verdict: Verdict) -> None:
    """The client dies while the arms go home."""
    stand.ensure_running()
    stand.end_run()
    client = Wire(stand.socket)
    client.send("home")
    wait_for(lambda: stand.state == "homing", 2.0)
    time.sleep(chance.uniform(0.0, 0.3))
    fault_ns = time.monotonic_ns()
    client.close()
    _reaches(stand, verdict, "unhomed", ANSWERED_S)
    _quiet(stand, verdict, fault_ns + round(HOMING_S * 1e9))


def _homed(stand: Stand) -> None:
    stand.end_run()
    stand.make_ready()


def _reaches(stand: Stand, verdict: Verdict, state: str, within_s: float) -> None:
    took_s = wait_for(lambda: stand.state == state, within_s + 2.0)
    verdict.seen_s = within_s + 2.0 if took_s is None else took_s
    verdict.demand(took_s is not None, f"is {stand.state}, not {state}")
    verdict.demand(verdict.seen_s <= within_s, f"seen after {verdict.seen_s:.2f} s only")


def _quiet(stand: Stand, verdict: Verdict, since_ns: int) -> None:
    """No edge from then on, and none to come."""
    time.sleep(QUIET_S)
    moved = len(after(edge_times_ns(stand.bench.memory), since_ns))
    verdict.demand(moved == 0, f"{moved} edges that nobody asks for any more")


CALLED_OFF_KINDS: dict[str, Callable[[Stand, Random, Verdict], None]] = {
    "cancel while planning": while_planning(lambda client: client.cancel(), "ready"),
    "off while planning": while_planning(lambda client: client.power_off(), "off"),
    "stop while planning": while_planning(lambda client: client.stop("a hand"), "stopped"),
    "pause while planning": held_planning,
    "client dies while planning": client_dies_planning,
    "client dies in mid-run": client_dies_running,
    "client dies while homing": client_dies_homing,
}
