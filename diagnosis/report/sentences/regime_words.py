"""In which regime an effect shows, in words."""

from __future__ import annotations

from diagnosis.answer.records import Finding
from diagnosis.report.sentences import words

REGIMES = {
    "gear_backlash": "after reversals and stops of {part}",
    "joint_friction": "after reversals of {part}",
    "viscous_friction": "while {part} moves, in proportion to its speed",
    "joint_compliance": "where the load on the joints is high",
    "payload": "everywhere, in proportion to the load on the joints",
    "home_offset": "everywhere, as a constant angle of {part}",
    "gear_ratio": "in proportion to the angle of {part}",
    "transmission_error": "in step with the angle of {part}",
    "encoder_error": "in step with the angle of {part}, on its encoder only",
    "lost_steps": "from one moment on",
    "following_lag": "while {part} moves and just after it stops",
    "upper_arm_length": "everywhere, with the pose",
    "forearm_length": "everywhere, with the pose",
    "base_radius": "everywhere, with the pose",
    "motor_azimuth": "everywhere, sideways of {part}",
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


def regime(finding: Finding) -> str:
    """Where a finding shows."""
    if finding.effect == "unknown":
        return words.listed([f"with {words.followed(name)}" for name in finding.depends_on[:1]])
    return REGIMES.get(finding.effect, "everywhere").format(part=words.part(finding.component))
