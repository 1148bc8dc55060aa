"""In words: in which regime an effect shows, and the summary of a diagnosis."""

from __future__ import annotations

from diagnosis.answer.records import Diagnosis
from diagnosis.answer.verdict import FAINT_REST

REGIMES = {
    "gear_backlash": "after reversals and stops of {c}",
    "joint_friction": "after reversals of {c}",
    "viscous_friction": "while {c} moves, in proportion to its speed",
    "joint_compliance": "where the load on the joints is high",
    "payload": "everywhere, in proportion to the load on the joints",
    "home_offset": "everywhere, as a constant angle of {c}",
    "gear_ratio": "in proportion to the angle of {c}",
    "transmission_error": "in step with the angle of {c}",
    "encoder_error": "in step with the angle of {c}, on its encoder only",
    "lost_steps": "from one moment on",
    "following_lag": "while {c} moves and just after it stops",
    "upper_arm_length": "everywhere, with the pose",
    "forearm_length": "everywhere, with the pose",
    "base_radius": "everywhere, with the pose",
    "motor_azimuth": "everywhere, sideways of {c}",
    "frame_tilt": "in proportion to the distance from the origin",
    "thermal_expansion": "growing since the start of the recording",
    "contact": "in the lowest part of the workspace",
    "resonance": "after starts and stops",
    "sensor_offset": "everywhere",
    "sensor_scale": "in proportion to the distance",
    "sensor_crosstalk": "with the square of the distance",
    "sensor_latency": "while the platform moves, on all sensors",
    "sensor_drift": "growing since the start of the recording",
    "stale_reading": "in one stretch of time",
}


def regime(effect: str, component: str) -> str:
    """Where an effect shows, in words."""
    return REGIMES.get(effect, "everywhere").format(c=component)


def summary(answer: Diagnosis) -> list[str]:
    """Plain sentences, most important first."""
    findings, fit, unexplained = answer.findings, answer.fit, answer.unexplained
    scale, unit = (1e3, "mm") if fit.unit == "m" else (1e3, f"m{fit.unit}")
    if answer.verdict == "nothing_missing":
        lines = [f"Nothing is missing in the model (p = {answer.false_alarm_p:.2g})."]
    elif not findings:
        lines = [unexplained.says]
    else:
        lines = [f"{number}. {finding.says}." for number, finding in enumerate(findings, start=1)]
        for finding in findings:
            others = [f"{a.effect} at {a.component}" for a in finding.alternatives]
            if others:
                lines.append(
                    f"This recording cannot tell {finding.effect} at {finding.component} from "
                    f"{', '.join(others)}."
                )
    if answer.loosely_built:
        lines.append("Besides, the machine is a little off everywhere, as build tolerances are.")
    lines.append(
        f"Mismatch {scale * fit.rms_before_m:.2f} {unit} before, {scale * fit.rms_after_m:.2f} "
        f"{unit} after, noise floor {scale * fit.noise_floor_m:.2f} {unit}; on held-out data "
        f"{scale * fit.holdout_rms_before_m:.2f} {unit} before, "
        f"{scale * fit.holdout_rms_after_m:.2f} {unit} after."
    )
    if findings and unexplained.share_of_mismatch > FAINT_REST:
        lines.append(unexplained.says)
    return lines
