"""The summary in the terminal."""

from __future__ import annotations

import io
import math
from typing import Any

import pytest
from rich.console import Console

from deltactl.diagnosis.answer.records import (
    Alternative,
    Evidence,
    Fit,
    OpenTie,
    ParameterResult,
    Unexplained,
    Where,
)
from deltactl.diagnosis.report.finding import where_line
from deltactl.diagnosis.report.in_words import in_words
from deltactl.diagnosis.report.screen import marked, screen_lines, sentences
from tests.diagnosis_report.conftest import report_text

VERDICTS = ("nothing_missing", "explained", "partly_explained", "unexplained")
NAN = math.nan


def shown(lines: list[str], width: int = 400) -> str:
    out = io.StringIO()
    console = Console(file=out, width=width, highlight=False)
    for line in lines:
        console.print(line)
    return out.getvalue()


def test_a_finding_has_size_interval_probability_and_alternatives(make: Any) -> None:
    text = report_text(make("explained"))
    assert "motor 2 0.498 degrees 0.476 to 0.521" in text
    assert "p < 1e-6 by its own test" in text
    assert "It could also be: a wrong home angle of motor 1 (2.1 worse in chi-square)" in text
    assert "from 83.2 to 240.0 s" in text
    assert "It shows in distance x from 0.0" not in text, "the whole recording is no place in time"
    assert "drag:" not in text.lower()  # a second parameter that tells a mechanic nothing


def test_before_and_after_stand_against_the_noise_and_on_held_out_data(make: Any) -> None:
    text = report_text(make("explained"))
    assert "Error 4.10 mm before, 2.21 mm after, 2.10 mm of noise" in text
    # (4.2^2 - 2.24^2) / (4.2^2 - 2.1^2) = 0.954
    assert "on held-out parts 4.20 mm before, 2.24 mm after (93 % of what" in text
    assert "held-out parts (causes were chosen with all of it)" in text


def test_one_off_events_are_not_expected_in_another_run(make: Any, parts: Any) -> None:
    fit = Fit(
        rms_before_m=0.003, rms_after_m=0.0016, noise_floor_m=0.0016,
        holdout_rms_before_m=0.0017, holdout_rms_after_m=0.0017, holdout="run",
    )  # fmt: skip
    once = report_text(make("explained", findings=[parts["lost_steps"]()], fit=fit))
    assert "what happens once does not come back in another run" in once
    lasting = report_text(make("explained", fit=fit))
    assert "1.70 mm after (below 1 % of what" in lasting


@pytest.mark.parametrize("verdict", VERDICTS)
def test_figures_that_are_not_known_are_never_printed_as_nan(
    make: Any, parts: Any, verdict: str
) -> None:
    hollow = parts["backlash"](
        parameters={"width": ParameterResult(value=NAN, ci95=[NAN, NAN], unit="rad")},
        evidence=Evidence(delta_chi2=NAN, p=NAN),
        share_of_mismatch=NAN,
    )
    fit = Fit(
        rms_before_m=NAN, rms_after_m=NAN, noise_floor_m=NAN,
        holdout_rms_before_m=NAN, holdout_rms_after_m=NAN,
    )  # fmt: skip
    lines = sentences(make(verdict, findings=[hollow], fit=fit, false_alarm_p=NAN))
    text = "\n".join(lines)
    assert "nan" not in text.lower().replace("resonance", "")
    assert "not known" in text
    assert "could not be computed" in text
    assert "nan" not in report_text(make(verdict, findings=[hollow], fit=fit)).lower().replace(
        "resonance", ""
    )


def test_markup_in_names_is_shown_and_not_obeyed(make: Any, parts: Any) -> None:
    evil = parts["backlash"](says="the gear of [red]motor[/red] [link=x] \\", component="[bold]m")
    text = shown(
        marked(
            screen_lines(make("explained", findings=[evil], not_held_out=["[red]a[/red]", "\\"]))
        )
    )
    assert "[red]a[/red]" in text
    assert "[bold]m" in text
    assert "[bold]Do this" not in text


def test_many_stretches_of_time_are_counted(parts: Any) -> None:
    where = Where(axes=[], times_s=[(float(k), k + 0.5) for k in range(9)], regime="")
    line = where_line(parts["backlash"](where=where), (0.0, 240.0))
    assert line == (
        "It shows from 0.0 to 0.5 s, from 1.0 to 1.5 s, from 2.0 to 2.5 s, from 3.0 to 3.5 s "
        "and 5 more times."
    )


def test_a_linear_axis_has_millimetres_and_newtons(make: Any, parts: Any) -> None:
    friction = parts["backlash"](
        effect="joint_friction",
        component="axis",
        says="dry friction brakes the axis",
        parameters={
            "torque": ParameterResult(value=20.4, ci95=[19.9, 20.9], unit="N"),
            "asymmetry": ParameterResult(value=0.05, ci95=[0.02, 0.08], unit="1"),
        },
    )
    fit = Fit(
        rms_before_m=0.02, rms_after_m=0.0005, noise_floor_m=0.0004,
        holdout_rms_before_m=0.021, holdout_rms_after_m=0.0006, unit="m",
    )  # fmt: skip
    text = report_text(make("explained", findings=[friction], fit=fit))
    assert "20.40 N 19.90 to 20.90" in text
    assert "orque" not in text
    assert "asymmetry 5.0 % 2.0 to 8.0" in text
    assert "friction in the axis" in text
    assert "20.0 mm before, 0.500 mm after" in text
    fit = fit.model_copy(update={"unit": "rad"})
    assert "1.15 degrees before" in report_text(make("explained", fit=fit))


def test_where_no_run_helps_no_motion_is_proposed(make: Any, parts: Any) -> None:
    other = Alternative(
        effect="joint_friction", component="motor2", delta_chi2=3.0, probability=0.4
    )
    tied = parts["backlash"](alternatives=[other], probability=0.6)
    tie = OpenTie(one=["gear_backlash motor2"], other=["joint_friction motor2"], minutes=8.0)
    open_ended = make("explained", findings=[tied], next_experiment=None, open_ties=[tie])
    text = "\n".join(sentences(open_ended))
    assert "No safe run" in text
    assert "would distinguish play from friction" not in text
    asked = make("explained", findings=[tied], next_experiment=None)
    assert "would distinguish play from friction" in "\n".join(sentences(asked))


def test_a_rest_that_is_too_little_is_reported_in_one_sentence(make: Any) -> None:
    rest = Unexplained(
        share_of_mismatch=0.004, p=1e-9, depends_on=["velocity_3"], component="motor3"
    )
    named = [one for one in make("explained").findings if one.effect != "unknown"]
    (says,) = [
        in_words(make("partly_explained", findings=named, unexplained=rest)).unexplained.says
    ]
    assert "and follows the speed of motor 3 at motor 3" in says
    assert "too little to act on" in says
    more = rest.model_copy(update={"share_of_mismatch": 0.4})
    answer = in_words(make("partly_explained", findings=named, unexplained=more))
    assert "too little" not in answer.unexplained.says
