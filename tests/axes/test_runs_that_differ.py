"""Two runs of one axis that differ in their gaps and their travel; efforts that repeat by place."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np
from scipy.signal import dlsim

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")
TURNS = ServoAxis(kind="servo_axis", name="turns", motion="rotary", inertia=2.0)
HZ, DAMPING, RATE_HZ = 4.0, 0.1, 50.0


def rung(recording: FlatRecording) -> FlatRecording:
    """The same axis with a load on a spring, by its exact response to a held input."""
    omega = 2.0 * np.pi * HZ
    decay = np.exp(-DAMPING * omega / RATE_HZ)
    angle = omega * np.sqrt(1.0 - DAMPING**2) / RATE_HZ
    poles = [1.0, -2.0 * decay * np.cos(angle), decay**2]
    position = recording.columns["position"]
    start = float(position[0])
    _, seen = dlsim(([sum(poles)], poles, 1.0), position - start)
    return replace(recording, columns={**recording.columns, "position": seen[:, 0] + start})


def with_gap(recording: FlatRecording, first: int, last: int) -> FlatRecording:
    """The same without some of its rows."""
    kept = np.r_[0:first, last : len(recording)]
    columns = {name: values[kept] for name, values in recording.columns.items()}
    return from_columns({"t": recording.t_s[kept], **columns}, "rig")


def test_a_ringing_axis_is_held_against_a_run_with_more_gaps(rigs: ModuleType) -> None:
    rig = rigs.FollowingRig(noise=1e-4)
    run, other = (rung(rig.record(seed)) for seed in (1, 2))
    for runs in ((run, with_gap(other, 500, 600)), (with_gap(run, 500, 600), other)):
        answer = diagnose_recordings(FOLLOWS, [runs[0]], holdout=[runs[1]])
        assert "resonance" in [finding.effect for finding in answer.findings]
        assert answer.fit.holdout_rms_after_m < 0.5 * answer.fit.holdout_rms_before_m


def cogging(recording: FlatRecording, size: float, period: float) -> FlatRecording:
    """The effort of a motor whose magnets hold it at places."""
    columns = recording.columns
    held = size * np.sin(2.0 * np.pi * columns["position"] / period)
    return replace(recording, columns={**columns, "effort": columns["effort"] + held})


def test_an_effort_that_repeats_by_place_is_mapped_in_detail(rigs: ModuleType) -> None:
    rig = rigs.ForcedRig(noise=2e-6)
    run, other = (cogging(rig.record(seed, 60.0, 0.5), 0.5, 0.08) for seed in (1, 2))
    answer = diagnose_recordings(TURNS, [run], holdout=[other])
    found = [finding for finding in answer.findings if finding.effect == "unknown"]
    assert ("position",) in [tuple(finding.depends_on) for finding in found]
    assert answer.fit.holdout_rms_after_m < 0.5 * answer.fit.holdout_rms_before_m


def test_a_spring_is_held_against_a_run_of_another_travel(rigs: ModuleType) -> None:
    rig = rigs.ForcedRig()

    def pulled(recording: FlatRecording) -> FlatRecording:
        columns = recording.columns
        effort = columns["effort"] + 30.0 * (columns["position"] - 0.2)
        return replace(recording, columns={**columns, "effort": effort})

    near, far = (pulled(rig.record(seed, size=size)) for seed, size in ((1, 0.3), (2, 1.5)))
    for runs in ((near, far), (far, near)):
        answer = diagnose_recordings(TURNS, [runs[0]], holdout=[runs[1]])
        assert answer.findings
        assert answer.fit.holdout_rms_after_m < 0.5 * answer.fit.holdout_rms_before_m
