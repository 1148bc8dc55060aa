"""Friction of an axis whose rough screw is larger than the gap between its directions."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

pytestmark = pytest.mark.study

SLIDE = ServoAxis(kind="servo_axis", name="slide", motion="linear", zero="arbitrary")
GAP_M, LATE_S = 26e-6, 0.02


def sliding(seed: int) -> FlatRecording:
    """A rough surface under a slide that goes to and fro between places, read twice a second."""
    rng = np.random.default_rng(seed)
    fine_s, every = 0.01, 50
    places_m = 1e-3 * rng.uniform(-20.0, 20.0, 26)
    parts = [np.full(200, places_m[0])]
    for start, place in itertools.pairwise(places_m):
        parts += [np.arange(start, place, math.copysign(2e-6, place - start)), np.full(200, place)]
    told = np.concatenate(parts)
    late = np.interp(np.arange(len(told)) - LATE_S / fine_s, np.arange(len(told)), told)
    at, came = float(late[0]), []
    for aim in late.tolist():
        at = min(max(at, aim - 0.5 * GAP_M), aim + 0.5 * GAP_M)
        came.append(at)
    seen = np.array(came)
    waves_m = np.array([0.9e-3, 0.37e-3, 2.1e-3, 0.23e-3])
    rough = sum(
        20e-6 * np.sin(2.0 * np.pi * seen / wave + phase)
        for wave, phase in zip(waves_m, rng.uniform(0.0, 6.0, 4), strict=True)
    )
    seen = seen + rough + 0.5e-6 * rng.standard_normal(len(seen))
    rows = slice(None, None, every)
    t_s = np.arange(len(told)) * fine_s
    return from_columns({"t": t_s[rows], "command": told[rows], "position": seen[rows]}, "slide")


def test_friction_is_found_beneath_a_rough_surface() -> None:
    answer = diagnose_recordings(SLIDE, [sliding(3)])
    widths = [
        one.parameters["width"].components[0]
        for one in answer.findings
        if one.effect in ("joint_friction", "gear_backlash")
    ]
    assert widths
    assert 0.5 * GAP_M < widths[0][0] < 1.5 * GAP_M
    assert answer.fit.rms_after_m < 8e-6
