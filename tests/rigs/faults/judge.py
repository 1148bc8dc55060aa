"""Judges one fault: what the drives saw, what the program says, and what the recording holds."""

from __future__ import annotations

import re
import time
from random import Random

import numpy as np

from deltactl.firmware_py.controller.states import State, said
from deltactl.foundation.errors import DeltactlError, NotReady
from deltactl.models.robot import AXES
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run
from tests.rigs.faults.edges import after, edge_times_ns
from tests.rigs.faults.kind import Kind
from tests.rigs.faults.run_delay import all_waits_s
from tests.rigs.faults.stand import T_PWM_NS, Stand, StandRun, wait_for
from tests.rigs.faults.verdict import Verdict, judge_gaps

LOST_S = 1.0
LONGEST_PAUSE_S = 0.25
READING_AGE_S = 0.2
SEES_AGAIN_S = 3.0


def try_fault(stand: Stand, kind: Kind, chance: Random) -> Verdict:
    """Run, wait for a random moment, make the fault, judge, and clear up."""
    verdict = Verdict(kind.name)
    before_s = stand.waited_s()
    try:
        run = stand.ensure_running()
        before_s = stand.waited_s()
        time.sleep(chance.uniform(0.05, 0.5))
        _inject_and_judge(stand, kind, run, verdict, chance)
        verdict.waited_s = all_waits_s(before_s, stand.waited_s())
    except (DeltactlError, AssertionError, OSError) as error:
        verdict.demand(False, f"{type(error).__name__}: {error}")
        verdict.waited_s = all_waits_s(before_s, stand.waited_s())
        stand.restart()
    return verdict


def _inject_and_judge(
    stand: Stand, kind: Kind, run: StandRun, verdict: Verdict, chance: Random
) -> None:
    fault_ns = time.monotonic_ns()
    undo = kind.inject(stand, chance)
    if kind.ends:
        _judge_end(stand, kind, run, verdict, fault_ns)
        _judge_refusals(stand, kind, verdict, undo)
        _judge_recording(stand, kind, run, verdict)
        _clear_up(stand, kind, verdict)
    else:
        time.sleep(kind.hold_s)
        undo()
        _judge_going_on(stand, kind, run, verdict, fault_ns)
        if kind.cuts_recording:
            stand.end_run()
            _judge_cut(stand, run, verdict, fault_ns)


def _judge_end(stand: Stand, kind: Kind, run: StandRun, verdict: Verdict, fault_ns: int) -> None:
    limit_s = kind.seen_s + 2.0
    reached = wait_for(lambda: stand.state == kind.ends, limit_s)
    verdict.seen_s = (time.monotonic_ns() - fault_ns) * 1e-9
    verdict.demand(reached is not None, f"is {stand.state}, not {kind.ends}")
    verdict.demand(verdict.seen_s <= kind.seen_s, f"seen after {verdict.seen_s:.2f} s only")
    time.sleep(0.05)
    edges_ns = edge_times_ns(stand.bench.memory)
    verdict.last_edge_s = max(0.0, (int(edges_ns[-1]) - fault_ns) * 1e-9)
    verdict.demand(
        verdict.last_edge_s <= kind.within_s, f"last edge {verdict.last_edge_s * 1e3:.1f} ms after"
    )
    why = stand.controller.status().why
    verdict.demand(re.search(kind.culprit, why) is not None, f"culprit not named: {why!r}")
    _judge_edges(stand, kind, run, verdict)


def _judge_edges(stand: Stand, kind: Kind, run: StandRun, verdict: Verdict) -> None:
    on_path_ns = after(edge_times_ns(stand.bench.memory), run.path_ns)
    judge_gaps(verdict, on_path_ns, T_PWM_NS)
    for _ in range(3):  # a moving robot steps between two looks
        counts = np.array(stand.controller.machine.output.status().counts)
        off = np.abs(counts - np.array(run.base) - np.array(stand.bench.counts()))
        lost = np.array(stand.bench.memory.lost()) - np.array(run.lost)
        moving = int(stand.state == "running")
        verdict.miscounted = int(np.maximum(off - lost - moving, 0).max())
        if verdict.miscounted <= kind.uncounted:
            return
    verdict.demand(False, f"counters off by {off.tolist()} with {lost.tolist()} lost")


def _judge_refusals(stand: Stand, kind: Kind, verdict: Verdict, undo: object) -> None:
    """Nothing moves while the cause is there, nor before it is acknowledged and homed."""
    _must_refuse(stand, verdict, kind.ends)
    if kind.refusal:
        try:
            stand.controller.acknowledge()
            verdict.demand(False, "acknowledged with the cause still there")
        except DeltactlError as error:
            named = re.search(kind.refusal, str(error)) is not None
            verdict.demand(named, f"refusal names no culprit: {error}")
    assert callable(undo)
    edges_before = stand.bench.memory.edges()
    undo()
    time.sleep(0.02)
    verdict.demand(stand.bench.memory.edges() == edges_before, "moved when the cause had gone")
    verdict.demand(stand.state == kind.ends, f"the latch did not hold: {stand.state}")
    if not kind.restart:
        _acknowledge(stand)
        verdict.demand(stand.state == "unhomed", f"acknowledged, and {stand.state}")
        _must_refuse(stand, verdict, "unhomed")


def _acknowledge(stand: Stand) -> None:
    """At once, but for sensors, which take a moment until they see again."""
    give_up_s = time.monotonic() + SEES_AGAIN_S
    while True:
        try:
            return stand.controller.acknowledge()
        except NotReady as error:
            if "blind" not in str(error) or time.monotonic() > give_up_s:
                raise
        time.sleep(0.02)


def _must_refuse(stand: Stand, verdict: Verdict, state: str) -> None:
    try:
        stand.controller.submit(stand.job)
        verdict.demand(False, f"took a job while {state}")
    except DeltactlError as error:
        named = f"the robot is {said(State(state))}" in str(error)
        verdict.demand(named, f"refused for another reason: {error}")


def _judge_recording(stand: Stand, kind: Kind, run: StandRun, verdict: Verdict) -> None:
    """Whole, and every edge in it."""
    result = stand.result_of(run)
    verdict.demand(result is not None and result.outcome == kind.ends, f"result {result}")
    recorded = _read(run, verdict)
    if recorded is None:
        return
    verdict.demand(recorded.complete, "the recording has no end")
    real_ns = after(edge_times_ns(stand.bench.memory), run.start_ns)
    _judge_lost(recorded, run, stand, verdict, int(real_ns[-1]))
    if not kind.restart:
        sent = np.abs(recorded.edges.steps).sum(axis=0).sum()
        verdict.demand(len(real_ns) <= sent, f"{len(real_ns)} edges seen, {sent} recorded")
    events = " / ".join(event.text for event in recorded.events)
    verdict.demand(re.search(kind.culprit.strip("^$"), events) is not None, "no event names it")


def _judge_lost(recorded: Run, run: StandRun, stand: Stand, verdict: Verdict, end_ns: int) -> None:
    """How much of the time up to `end_ns` is not recorded; the first edges of both are the same."""
    t_ns = recorded.edges.t_ns[np.any(recorded.edges.steps, axis=1)]
    real_ns = after(edge_times_ns(stand.bench.memory), run.start_ns)
    if not len(t_ns) or not len(real_ns):
        verdict.demand(False, "no edge recorded")
        return
    missing_ns = int(end_ns - real_ns[0]) - int(t_ns[-1] - t_ns[0])
    verdict.unrecorded_s = max(0.0, missing_ns * 1e-9)
    verdict.demand(verdict.unrecorded_s <= LOST_S, f"{verdict.unrecorded_s:.2f} s not recorded")


def _judge_cut(stand: Stand, run: StandRun, verdict: Verdict, fault_ns: int) -> None:
    """The disk failed in the middle: the run went on, and what was written can be read."""
    result = stand.result_of(run)
    done = result is not None and result.outcome == "cancelled" and result.recording_error != ""
    verdict.demand(done, f"result {result}")
    recorded = _read(run, verdict)
    if recorded is not None:
        _judge_lost(recorded, run, stand, verdict, fault_ns)


def _read(run: StandRun, verdict: Verdict) -> Run | None:
    try:
        return read_run(run.recording)
    except DeltactlError as error:
        verdict.demand(False, f"recording unreadable: {error}")
        return None


def _judge_going_on(
    stand: Stand, kind: Kind, run: StandRun, verdict: Verdict, fault_ns: int
) -> None:
    took = wait_for(lambda: _well(stand), kind.within_s)
    verdict.last_edge_s = (time.monotonic_ns() - fault_ns) * 1e-9 - kind.hold_s
    health = stand.rig.bank.health()
    verdict.demand(took is not None, f"not well again: {stand.state}, {health}")
    verdict.demand(stand.state == "running", f"{stand.state}: {stand.controller.status().why}")
    edges_ns = after(edge_times_ns(stand.bench.memory), fault_ns - 10 * T_PWM_NS)
    pauses_ns = np.diff(edges_ns, prepend=fault_ns, append=time.monotonic_ns())
    verdict.pause_s = float(pauses_ns.max()) * 1e-9
    verdict.demand(verdict.pause_s < LONGEST_PAUSE_S, f"paused for {verdict.pause_s:.2f} s")
    _judge_edges(stand, kind, run, verdict)
    if kind.culprit:
        _judge_naming(stand, kind, run, verdict)


def _judge_naming(stand: Stand, kind: Kind, run: StandRun, verdict: Verdict) -> None:
    """In the status, or in the events of the recording so far."""
    says = stand.controller.status().recording_error
    if not kind.cuts_recording:
        time.sleep(1.2)  # a block is at most a second old when it is written
        recorded = _read(run, verdict)
        says = " / ".join(event.text for event in recorded.events) if recorded else ""
    verdict.demand(re.search(kind.culprit, says) is not None, f"culprit not named: {says!r}")


def _well(stand: Stand) -> bool:
    """Moving, with three fresh good readings."""
    status = stand.controller.status()
    fresh = all(
        one.health == "ok" and one.gate == "good" and (one.age_s or 0.0) < READING_AGE_S
        for one in status.sensors
    )
    return status.state == "running" and fresh and len(status.sensors) == len(AXES)


def _clear_up(stand: Stand, kind: Kind, verdict: Verdict) -> None:
    stand.run = None
    if not kind.restart:
        return
    stand.restart()
    verdict.demand(stand.state == "off", f"started again, and {stand.state}")
    _must_refuse(stand, verdict, "off")
