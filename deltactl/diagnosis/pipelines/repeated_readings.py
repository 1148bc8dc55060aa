"""Findings of old values that a sensor repeated."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.answer.records import Evidence, Finding, ParameterResult, Where
from deltactl.diagnosis.observations.stale_readings import Stale
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.selection.named_first import Selected
from deltactl.models.effects import Search, found_by


def repeated(plant: RegressionPlant, selected: Selected) -> list[Finding]:
    """One for each stretch of them."""
    return [_finding(plant, selected, run) for run in plant.stale]


def _finding(plant: RegressionPlant, selected: Selected, run: Stale) -> Finding:
    readings = plant.readings
    column, count = readings.names.index(run.channel), len(readings.t_s)
    begin, end = float(readings.t_s[run.first]), float(readings.t_s[run.last])
    rows = slice(column * count + run.first + 1, column * count + run.last + 1)
    miss, noise = selected.best.residual[rows], selected.noise
    own = noise.sigma[noise.rows // count == column]
    # Rounding makes it look one or two longer, nothing makes it look shorter.
    half, seconds = readings.period_s, end - begin + readings.period_s
    own_begin, own_end = (readings.own_time_s(t_s) for t_s in (begin, end))
    own_end += 0.5 * half
    own_begin -= 0.5 * half
    times = [[own_begin - half, own_begin + half], [own_end - half, own_end + half]]
    return Finding(
        effect=found_by(Search.REPEATS).name,
        component=run.channel,
        says="",
        parameters={
            "times_s": ParameterResult(value=[own_begin, own_end], ci95=times, unit="s"),
            "duration": ParameterResult(
                value=seconds, ci95=[seconds - 2.5 * half, seconds + half], unit="s"
            ),
        },
        where=Where(
            axes=[run.channel],
            times_s=[(own_begin, own_end)],
            recordings=[readings.recording_of(begin)],
        ),
        evidence=Evidence(
            delta_chi2=float(np.nansum(miss**2)) / float(np.median(own)) ** 2,
            p=float(np.exp(run.log_p)),
        ),
        probability=1.0 - float(np.exp(run.log_p)),
        share_of_mismatch=0.0 if selected.best.found else 1.0,
    )
