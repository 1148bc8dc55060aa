"""What to do about a finding, for the person with the spanner: one sentence for each effect.

A table by effect. `{part}` is the component in words, `{size}` the main size as people use it,
`{true}` what the robot file's own value becomes with it (where it has one).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from diagnosis.answer.corrected_robot import sure
from diagnosis.answer.records import Diagnosis, Finding, ParameterResult
from diagnosis.answer.verdict import claimed
from diagnosis.report.sentences import words
from diagnosis.report.sentences.sizes import quantity
from diagnosis.report.sentences.sureness import settled
from models.robot import DeltaRobot, RobotModel, per_arm

NOTE = " (deltactl diagnose ... --save-robot NEW.yaml{all} records it)"
"""For what can be described in the robot file instead of being repaired."""

RUN_FIRST = (
    "Before anything is taken apart, record the run proposed below, which is made to tell the"
    " causes apart (--next-job JOB.yaml writes it), and diagnose it together with this recording."
)

REMEDIES: dict[str, str] = {
    "gear_backlash": "take up the play of {part} ({size} at its output): tighten coupling and set"
    " screws; if it stays, replace the gear",
    "joint_friction": "free the bearings of {part} (look for what rubs, clean, grease) if {size} of"
    " friction is more than its maker states; or record it",
    "viscous_friction": "look at the grease and seals of {part}, or record its friction",
    "stribeck_friction": "grease {part}: it sticks at low speed",
    "joint_compliance": "look for loose clamps and thin shafts at {part}: it yields under load",
    "home_offset": "correct the home stop or jig of {part}, which is {size} off; or record the"
    " offset",
    "gear_ratio": "compare gear and microstep switches of {part} with the robot file: the"
    " ratio is {size} off",
    "transmission_error": "replace the gear of {part} if {size} is too much; or record the error,"
    " and jobs compensate it",
    "encoder_error": "centre the encoder of {part}: it errs by {size} periodically",
    "lost_steps": "home again; then run slower or softer, and look for what held {part} up:"
    " {size} were lost",
    "following_lag": "tighten the control of {part}, or allow for its being late by {size}",
    "upper_arm_length": "set the upper arm of {part} to {true} in the robot file, or replace it",
    "forearm_length": "set the forearm of {part} to {true} in the robot file, or replace it",
    "base_radius": "measure base and platform: the difference of their radii is {true}",
    "motor_azimuth": "turn {part} on the base, it is {size} off; or record the angle",
    "frame_tilt": "align the sensors with the robot, or record their rotation ({size})",
    "thermal_expansion": "let the arms warm up before exact work: they grow by {size}",
    "payload": "weigh what the platform carries: it is {size} against the robot file",
    "contact": "clear away what stops the platform at {size}",
    "resonance": "accelerate more gently, or stiffen the frame: it rings at {size}",
    "sensor_offset": "set {part} to zero ('deltactl sensors --calibrate'): it reads {size} off",
    "sensor_scale": "have {part} calibrated: its scale is {size} off",
    "sensor_crosstalk": "clean the window of {part}, or move it: its error grows with distance",
    "sensor_latency": "allow for readings that come {size} late, or read them faster",
    "sensor_drift": "let {part} warm up before use: it drifts by {size}",
    "stale_reading": "look at the cable and supply of {part}: it repeats old values",
    "inertia": "record the true inertia of {part}: {size}",
    "effort_offset": "balance {part}, or set its effort to zero at rest: {size} always acts",
    "effort_gain": "set the scale between effort and force of {part}: it is {size} off",
}
"""By effect; for one without a line nobody can say what to do."""

OF_A_SENSOR_ALONE: dict[str, str] = {
    "sensor_offset": "set {part} to zero: it reads {size} off",
}
"""Where the sensor is not part of a robot."""

WRITABLE = frozenset({
    "home_offset", "transmission_error", "upper_arm_length", "forearm_length", "motor_azimuth",
    "base_radius", "frame_tilt", "inertia", "joint_friction", "viscous_friction",
})  # fmt: skip
SIGNED = frozenset({"gear_ratio", "sensor_scale", "effort_gain", "payload", "sensor_offset"})
_ARM = re.compile(r"(?:arm|motor)([123])")


@dataclass(frozen=True, slots=True)
class Remedy:
    """What to do, and whether something else should be ruled out first."""

    says: str
    unsure: str

    @property
    def line(self) -> str:
        """As one sentence."""
        return words.sentence(self.says + self.unsure)


def remedies(diagnosis: Diagnosis, robot: RobotModel | None = None) -> list[str]:
    """One sentence for each finding that can be remedied, the surest and largest first.

    Before them, where causes are tied, the run that would tell them apart.
    """
    named = [one for one in diagnosis.findings if claimed(one)]
    found = (remedy(one, robot, sure(one, diagnosis)) for one in named)
    lines = [one.line for one in found if one is not None]
    plan = diagnosis.next_experiment
    if lines and plan is not None and any(tied(one) for one in named):
        lines.insert(0, RUN_FIRST)
    return lines


def tied(finding: Finding) -> bool:
    """Whether it could as well be something else, by this recording."""
    return bool(finding.alternatives) and not settled(finding)


def remedy(finding: Finding, robot: RobotModel | None, certain: bool = True) -> Remedy | None:
    """What to do about one finding; None where nobody can say.

    certain: it is written into a robot file without being asked for.
    """
    alone = OF_A_SENSOR_ALONE if finding.component == "axis" else {}
    text = alone.get(finding.effect, REMEDIES.get(finding.effect))
    main = next(iter(finding.parameters.items()), None)
    if text is None or main is None:
        return None
    name, result = _late(finding) if finding.effect == "following_lag" else main
    largest = max((value for value, _, _ in result.components), key=abs)
    shown = quantity(largest, result.unit, name, 3)
    if finding.effect not in SIGNED:
        shown = shown.lstrip("+\u2212")
    true = _true(finding, robot, largest) or f"{shown} otherwise"
    says = text.format(part=words.part_of(finding.effect, finding.component), size=shown, true=true)
    if finding.effect in WRITABLE:
        says += NOTE.format(all="" if certain else " --all")
    likely = finding.alternatives if tied(finding) else []
    others = [words.rival(finding.effect, o.effect, o.component) for o in likely]
    unsure = f"; but first rule out {others[0]}, which looks the same here" if others else ""
    if len(others) > 1:
        unsure = f"; but first rule out {len(others)} others that look the same here (below)"
    return Remedy(says, unsure)


def _late(finding: Finding) -> tuple[str, ParameterResult]:
    """Of lag and dead time the larger."""
    times = ((n, p) for n, p in finding.parameters.items() if p.unit == "s")
    return max(
        times,
        key=lambda one: one[1].components[0][0],
        default=next(iter(finding.parameters.items())),
    )


def _true(finding: Finding, robot: RobotModel | None, error: float) -> str:
    """The robot file's length with what was found added; empty where it has none."""
    if not isinstance(robot, DeltaRobot):
        return ""
    geometry = robot.geometry
    arm = _ARM.fullmatch(finding.component)
    lengths = {
        "upper_arm_length": per_arm(geometry.upper_arm_m),
        "forearm_length": per_arm(geometry.forearm_m),
        "base_radius": geometry.radius_m,
    }.get(finding.effect)
    if lengths is None or (arm is None and finding.effect != "base_radius"):
        return ""
    nominal_m = float(lengths[int(arm[1]) - 1 if arm is not None else 0])
    return f"{1e3 * (nominal_m + error):.1f} mm (not {1e3 * nominal_m:.1f} mm)"
