"""Diagnoses made by hand, with pictures that a formula gives."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import (
    Alternative,
    Channel,
    Diagnosis,
    Evidence,
    Finding,
    Fit,
    NextExperiment,
    NotTestable,
    ParameterResult,
    Picture,
    SmallestDetectable,
    Unexplained,
    Where,
)
from deltactl.diagnosis.report.finding import UNKNOWN_SPAN
from deltactl.diagnosis.report.page import finding_rows, report_html
from deltactl.diagnosis.report.templates import say
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel, ServoAxis, StepperAxis
from tests.rigs.charts import nothing_drawn

Make = Callable[..., Any]

DRAWN = {"test_long_recordings_stay_small"}


@pytest.fixture(autouse=True)
def charts_left_out(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Charts take a twentieth of a second each; most tests here look at what is around them."""
    if request.node.name not in DRAWN:
        monkeypatch.setattr("deltactl.charts.document.document", nothing_drawn)


def card_text(finding: Finding, answer: Diagnosis) -> str:
    """What the report's table says of a finding."""
    (card,) = finding_rows(answer.model_copy(update={"findings": [finding]}), UNKNOWN_SPAN)
    return _text(card)


def report_text(answer: Diagnosis, robot: RobotModel | None = None) -> str:
    """What the report says, without the tables of all figures."""
    return _text(report_html(answer, robot or delta_robot()).partition(say("page.made"))[0])


def _text(page: str) -> str:
    plain = re.sub(r"<(style|script)\b.*?</\1>|<[^>]+>", " ", page, flags=re.DOTALL)
    return re.sub(r" (?=[.,:;)])", "", " ".join(html.unescape(plain).split()))


def delta_robot(name: str = "practice-robot") -> DeltaRobot:
    return DeltaRobot.model_validate(
        {
            "kind": "delta",
            "name": name,
            "geometry": {
                "base_radius_m": 0.325,
                "platform_radius_m": 0.075,
                "upper_arm_m": 0.25,
                "forearm_m": 0.5,
            },
            "drive": {"microsteps_per_rev": 1600, "gear_ratio": 10},
            "sensors": {
                "x": {"offset_m": 0.60, "axis": (1.0, 0.0, 0.0)},
                "y": {"offset_m": 0.60, "axis": (0.0, 1.0, 0.0)},
                "z": {"offset_m": 0.90, "axis": (0.0, 0.0, 1.0)},
            },
        }
    )


def lone_robots() -> list[Any]:
    return [
        ServoAxis(kind="servo_axis", name="emps", motion="linear", inertia=95.1),
        ServoAxis(kind="servo_axis", name="elbow", motion="rotary", inertia=0.02),
        StepperAxis.model_validate(
            {
                "kind": "stepper_axis",
                "name": "tank",
                "drive": {"microsteps_per_rev": 51200, "gear_ratio": 12339.5},
            }
        ),
        RangeSensor(kind="range_sensor", name="vl53"),
    ]


def backlash(**changes: Any) -> Finding:
    parts: dict[str, Any] = {
        "effect": "gear_backlash",
        "component": "motor2",
        "says": "the gear of motor2 has 0.498 degrees (8.70 mrad) of backlash at the arm",
        "parameters": {
            "width": ParameterResult(value=0.0087, ci95=[0.0083, 0.0091], unit="rad"),
            "drag": ParameterResult(value=20.0, ci95=[1.0, 1e300], unit="N m s/rad"),
        },
        "where": Where(
            axes=["range_y", "range_z"],
            times_s=[(0.0, 240.0)],
            regime="after reversals and stops of motor2",
        ),
        "evidence": Evidence(delta_chi2=812.3, p=1e-12),
        "share_of_mismatch": 0.83,
    }
    return Finding(**{**parts, **changes})


def lost_steps(**changes: Any) -> Finding:
    parts: dict[str, Any] = {
        "effect": "lost_steps",
        "component": "motor1",
        "says": "motor1 lost 32 microsteps at 83.20 s and stayed there",
        "parameters": {
            "steps": ParameterResult(value=32.0, ci95=[28.5, 35.5], unit="microsteps"),
            "time": ParameterResult(value=83.2, ci95=[83.1, 83.3], unit="s"),
        },
        "where": Where(axes=["range_x"], times_s=[(83.2, 240.0)], regime="from one moment on"),
        "evidence": Evidence(delta_chi2=96.0, p=4e-5),
        "share_of_mismatch": 0.12,
        "alternatives": [
            Alternative(effect="home_offset", component="motor1", delta_chi2=2.1),
            Alternative(effect="sensor_drift", component="range_x", delta_chi2=3.4),
        ],
    }
    return Finding(**{**parts, **changes})


def unknown(**changes: Any) -> Finding:
    parts: dict[str, Any] = {
        "effect": "unknown",
        "component": "motor3",
        "says": "something at motor3 that no known effect explains follows theta_3",
        "parameters": {"size_rms": ParameterResult(value=0.002, ci95=[0.0018, 0.0022], unit="rad")},
        "where": Where(axes=["range_x"], times_s=[(0.0, 240.0)], regime="with theta_3"),
        "evidence": Evidence(delta_chi2=300.0, p=1e-9),
        "share_of_mismatch": 0.6,
        "depends_on": ["theta_3"],
        "has_memory": True,
    }
    return Finding(**{**parts, **changes})


RANGES = ("range_x", "range_y", "range_z")


def picture(samples: int = 3000, names: tuple[str, ...] = RANGES) -> Picture:
    t_s = np.linspace(0.0, 240.0, samples)
    random = np.random.default_rng(7)
    angles = [0.3 + 0.4 * np.sin(2 * np.pi * t_s / 9.0 + 2.1 * k) for k in range(3)]
    covariates = {f"theta_{k + 1}": angle for k, angle in enumerate(angles)}
    speeds = [np.gradient(angle, t_s) for angle in angles]
    covariates |= {f"speed_{k + 1}": speed for k, speed in enumerate(speeds)}
    channels = []
    for number, name in enumerate(names):
        nominal = 0.6 + 0.1 * np.sin(2 * np.pi * t_s / 9.0 + number)
        miss = 0.003 * np.sign(speeds[1]) * (number > 0) + 0.002 * (t_s > 83.2) * (number == 0)
        observed = nominal + miss + 0.002 * random.standard_normal(samples)
        observed[random.random(samples) < 0.02] = np.nan
        observed[random.integers(0, samples, 5)] += 0.5
        covariates[f"range_{'xyz'[number % 3]}"] = nominal - 0.6
        channels.append(
            Channel(
                name=name, unit="m", observed=observed, before=nominal,
                after=nominal + miss, noise=0.002,
            )
        )  # fmt: skip
    covariates["time"] = t_s
    return Picture(t_s=t_s, channels=channels, covariates=covariates)


def diagnosis(verdict: str = "explained", **changes: Any) -> Diagnosis:
    findings = {
        "nothing_missing": [],
        "explained": [backlash(), lost_steps()],
        "partly_explained": [backlash(), unknown()],
        "unexplained": [unknown()],
    }[verdict]
    parts: dict[str, Any] = {
        "verdict": verdict,
        "false_alarm_p": 0.31 if verdict == "nothing_missing" else 1e-14,
        "fit": Fit(
            rms_before_m=0.0041,
            rms_after_m=0.00221,
            noise_floor_m=0.0021,
            holdout_rms_before_m=0.0042,
            holdout_rms_after_m=0.00224,
        ),
        "findings": findings,
        "unexplained": Unexplained(
            share_of_mismatch=0.02, depends_on=[], says="The remaining error is noise."
        ),
        "next_experiment": NextExperiment(
            job={"path": {"shape": "circle", "radius_m": 0.1, "turns": -3}, "repeats": 2},
            tells_apart=["lost_steps motor1", "home_offset motor1"],
            expected_delta_chi2=54.0,
            minutes=2.5,
        ),
        "not_testable": [
            NotTestable(effect="encoder_error", component=f"motor{k}", why="no angles were read")
            for k in (1, 2, 3)
        ],
        "smallest_detectable": [
            SmallestDetectable(
                effect="gear_backlash", component="motor2", parameter="width", value=0.003,
                unit="rad",
            ),
            SmallestDetectable(
                effect="gear_ratio", component="motor1", parameter="scale", value=0.003, unit="1"
            ),
            SmallestDetectable(
                effect="joint_compliance", component="joints", parameter="stiffness",
                value=35000.0, unit="N m/rad",
            ),
        ],
        "robot": "practice-robot",
        "recordings": ["recording.csv.gz"],
        "picture": picture(),
    }  # fmt: skip
    return Diagnosis(**{**parts, **changes})


NAN = math.nan


@pytest.fixture
def make() -> Make:
    """Builds a diagnosis of a verdict, with changes."""
    return diagnosis


@pytest.fixture
def parts() -> dict[str, Make]:
    """Builders of its parts."""
    return {
        "backlash": backlash,
        "lost_steps": lost_steps,
        "unknown": unknown,
        "picture": picture,
        "delta": delta_robot,
        "lone": lone_robots,
    }
