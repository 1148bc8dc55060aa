"""One recording: its diagnosis as plain rows, whatever happens. Runs on the workers."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import DeltactlError

Row = dict[str, Any]


def _quantity(effect: str, parameter: str) -> str:
    """The effect that a row counts for. Play and friction both show as a width at reversals; one
    recording names the one, the next the other. Over many they are one quantity; the row keeps what
    was said beside it.
    """
    from deltactl.models.effects import Trait, has, with_trait

    same = parameter == "width" and has(effect, Trait.HYSTERESIS)
    return with_trait(Trait.HYSTERESIS)[0] if same else effect


def diagnose_one(recording: str, robot: str) -> Row:
    """Answer of one recording: {"verdict", "findings": [...], ...} or {"error": one line}.

    In this process alone: the cores are busy with other recordings, or a robot runs on them.
    """
    from deltactl.diagnosis.api import diagnose
    from deltactl.diagnosis.estimation.side_by_side import alone

    started_s = time.monotonic()
    try:
        with alone():
            answer = diagnose([Path(recording)], Path(robot))
    except (DeltactlError, OSError) as error:
        return {"error": " ".join(str(error).split())}
    except Exception as error:
        # A fleet does not stop at one file, whatever is wrong with it.
        return {"error": f"{recording}: {type(error).__name__}: {error}"}
    fit = answer.fit
    return {
        "verdict": answer.verdict,
        "false_alarm_p": answer.false_alarm_p,
        "rms_before": fit.rms_before_m,
        "rms_after": fit.rms_after_m,
        "noise_floor": fit.noise_floor_m,
        "findings": [row for finding in answer.findings for row in _sizes(finding)],
        "detectable": {
            f"{one.effect} {one.component}": one.value for one in answer.smallest_detectable
        },
        "seconds": time.monotonic() - started_s,
    }


def _sizes(finding: Any) -> list[Row]:
    """A row for each size of a finding (a vector gives several)."""
    rows = []
    for name, parameter in finding.parameters.items():
        for number, (value, low, high) in enumerate(parameter.components):
            whole = len(parameter.components) == 1
            rows.append(
                {
                    "effect": _quantity(finding.effect, name),
                    "named": finding.effect,
                    "component": finding.component,
                    "parameter": name if whole else f"{name}[{number}]",
                    "value": value,
                    "low": low,
                    "high": high,
                    "unit": parameter.unit,
                    "probability": finding.probability,
                    "share": finding.share_of_mismatch,
                    "alternatives": [
                        {
                            "effect": one.effect,
                            "component": one.component,
                            "probability": one.probability,
                        }
                        for one in finding.alternatives
                    ],
                }
            )
    return rows
