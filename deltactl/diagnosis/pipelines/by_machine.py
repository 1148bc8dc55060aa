"""The ways from an admitted machine to its answer: a delta, an axis, a sensor, a servo robot.

A servo robot is looked at in two parts: torques by the disturbances, geometry by the sensors. The
encoders say where the arms were, so sensors are compared with the measured angles, not with what
was asked for; what following costs is the torques' business.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from deltactl.diagnosis.admission.admit import Admission, Delta, Lone
from deltactl.diagnosis.admission.axis_match import check_together, too_large
from deltactl.diagnosis.answer.records import Diagnosis, Finding, NotTestable, Picture, Verdict
from deltactl.diagnosis.evidence.detection import Progress
from deltactl.diagnosis.experiment.next_motion import next_motion
from deltactl.diagnosis.experiment.propose import Proposal
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.pipelines.nonlinear import diagnose_model
from deltactl.diagnosis.pipelines.regression import NextRun, diagnose_plant
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.diagnosis.plants.chain.poses import PosePlant
from deltactl.diagnosis.plants.delta.next_runs import next_runs
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.servo_delta import CHANNEL, ServoDelta
from deltactl.diagnosis.report.in_words import in_words, kinds_of
from deltactl.models.effects.chain_joints import chain_effects
from deltactl.models.effects.kind import MOTORS
from deltactl.models.effects.servo_joints import SERVO_EFFECTS
from deltactl.models.robot import ChainRobot, DeltaRobot, ServoAxis


def diagnosed(
    admission: Admission,
    progress: Progress = lambda _: None,
    limits: MotionLimits | None = None,
    thorough: bool = False,
) -> Diagnosis:
    """The answer, by the kind of machine. Raises RefusedRecording for what was not admitted.

    limits: for the run that is proposed. thorough: go on beyond the limit of work.
    """
    machine = admission.passed()
    if isinstance(machine, Delta):
        drive = machine.model.robot.drive
        return _delta(machine, drive.rad_per_step if drive else 0.0, progress, limits, thorough)
    if isinstance(machine, Lone):
        if isinstance(machine.plant, ServoDelta):
            return _joints(machine, progress)
        if isinstance(machine.plant, ChainPlant):
            return _chain(machine, progress)
        if isinstance(machine.plant, PosePlant):
            return _posed(machine, progress)
        return _axis(admission, machine, progress)
    outside = _delta(machine.outside, 0.0, progress, limits, thorough)
    if not isinstance(machine.torques, Lone):
        return _alone(outside, machine.torques.says)
    return joined(_joints(machine.torques, progress), in_words(outside))


def _delta(
    machine: Delta,
    rad_per_step: float,
    progress: Progress,
    limits: MotionLimits | None,
    thorough: bool,
) -> Diagnosis:
    runs = partial(next_runs, machine.model, limits)
    return diagnose_model(machine.model, rad_per_step, machine.held_out, progress, runs, thorough)


def _answered(
    machine: Lone, progress: Progress, runs: NextRun = lambda _: Proposal(None)
) -> Diagnosis:
    """The engine's answer, with the recordings that could not be held out."""
    try:
        answer = diagnose_plant(machine.plant, machine.others, progress, machine.singles, runs)
    except OverflowError:
        raise too_large() from None
    left_out = [refusal.says for refusal in machine.left_out]
    return answer.model_copy(update={"not_held_out": left_out})


def _axis(admission: Admission, machine: Lone, progress: Progress) -> Diagnosis:
    """A single axis or a sensor."""
    robot = admission.robot
    assert not isinstance(robot, DeltaRobot | ChainRobot)
    plant, recording = machine.plant, admission.recordings[0]
    answer = _answered(machine, progress)
    if isinstance(plant, CommandedAxis):
        check_together(plant, answer.fit, answer.findings, recording)
    # Whether nobody need be asked to enter in the robot file what pulls at it.
    pull_said = not isinstance(robot, ServoAxis) or robot.gravity is not None
    answer = answer.model_copy(update={"pull_said": pull_said})
    return in_words(answer, kinds_of(robot, answer), robot.effects)


def _joints(machine: Lone, progress: Progress) -> Diagnosis:
    """A servo delta by its disturbance estimates."""
    plant = machine.plant
    assert isinstance(plant, ServoDelta)
    answer = _answered(machine, progress)
    pictured = _by_joint(answer, MOTORS, float(plant.readings.t_s[0]), plant.span_s, CHANNEL)
    return in_words(pictured, SERVO_EFFECTS)


def _chain(machine: Lone, progress: Progress) -> Diagnosis:
    """A chain of joints by its efforts."""
    plant = machine.plant
    assert isinstance(plant, ChainPlant)
    answer = _answered(machine, progress, partial(next_motion, plant))
    whole, chain = plant.moved.whole, plant.chain
    if answer.picture is not None:
        answer = answer.model_copy(update={"picture": _pictured(answer.picture, plant)})
    answer = _by_joint(answer, chain.joints, float(whole.t_s[0]), whole.span_s, plant.channel)
    kinds = chain_effects(dict(zip(chain.joints, chain.slides, strict=True)), chain.tip)
    return in_words(answer, kinds, plant.robot.effects)


def _posed(machine: Lone, progress: Progress) -> Diagnosis:
    """A chain of joints by places and orientations that were measured from outside."""
    plant = machine.plant
    assert isinstance(plant, PosePlant)
    answer = _answered(machine, progress)
    if answer.picture is not None:
        answer = answer.model_copy(update={"picture": _of_channels(answer.picture, plant)})
    whole = [(float(plant.poses.t_s[0]), float(plant.poses.t_s[-1]))]
    found = [
        one.model_copy(
            update={"where": one.where.model_copy(update={"axes": plant.names, "times_s": whole})}
        )
        for one in answer.findings
    ]
    answer = answer.model_copy(update={"findings": found})
    slides = dict(zip(plant.joints, plant.chain.slides, strict=True))
    return in_words(answer, chain_effects(slides, plant.chain.tip), plant.robot.effects)


DRAWN = ("observed", "before", "after", "counted")


def _of_channels(picture: Picture, plant: PosePlant) -> Picture:
    """One channel for each column that was measured, over the poses."""
    (whole,) = picture.channels
    channels = []
    for number, name in enumerate(plant.names):
        parts = {part: plant.layout.apart(getattr(whole, part))[:, number] for part in DRAWN}
        channels.append(whole.model_copy(update={"name": name, **parts}))
    covariates = {
        name: plant.layout.apart(values)[:, 0] for name, values in picture.covariates.items()
    }
    return Picture(t_s=plant.poses.t_s, channels=channels, covariates=covariates)


def _pictured(picture: Picture, plant: ChainPlant) -> Picture:
    """The same with each joint in one piece."""
    layout = plant.layout

    def whole(column: FloatArray) -> FloatArray:
        return layout.apart(column).T.ravel()

    channels = [
        one.model_copy(update={n: whole(getattr(one, n)) for n in DRAWN})
        for one in picture.channels
    ]
    covariates = {name: whole(values) for name, values in picture.covariates.items()}
    t_s = np.tile(plant.moved.whole.t_s[layout.kept], len(plant.joints))
    return Picture(t_s=t_s, channels=channels, covariates=covariates)


def _by_joint(
    answer: Diagnosis, joints: Sequence[str], first_s: float, span_s: float, channel: str
) -> Diagnosis:
    """Findings and pictures of joints that were end to end, one channel a joint."""
    found = [_of_joint(one, joints, first_s, span_s, channel) for one in answer.findings]
    picture = joint_channels(answer, len(joints), channel)
    return answer.model_copy(update={"findings": found, "picture": picture})


def _of_joint(
    finding: Finding, joints: Sequence[str], first_s: float, span_s: float, channel: str
) -> Finding:
    """Its place in the recording's own time, on the channels of its joint."""
    own = [finding.component] if finding.component in joints else joints
    axes = [f"{channel}_{list(joints).index(joint) + 1}" for joint in own]
    where = finding.where.model_copy(
        update={"axes": axes, "times_s": [(first_s, first_s + span_s)], "recordings": [1]}
    )
    return finding.model_copy(update={"where": where})


def joint_channels(
    answer: Diagnosis, joints: int = len(MOTORS), channel: str = CHANNEL
) -> Picture | None:
    """One channel a joint, in the recording's own time, of several that were end to end."""
    picture = answer.picture
    if picture is None:
        return None
    (whole,) = picture.channels
    each = len(picture.t_s) // joints
    parts = [slice(each * j, each * (j + 1)) for j in range(joints)]
    channels = [
        whole.model_copy(
            update={"name": f"{channel}_{j + 1}"}
            | {name: getattr(whole, name)[rows] for name in DRAWN}
        )
        for j, rows in enumerate(parts)
    ]
    names = {"position": "theta", "velocity": "speed"}
    covariates = {
        f"{new}_{j + 1}": picture.covariates[old][rows]
        for old, new in names.items()
        for j, rows in enumerate(parts)
    }
    return Picture(t_s=picture.t_s[:each], channels=channels, covariates=covariates)


def _alone(outside: Diagnosis, why: str) -> Diagnosis:
    """Geometry only: the torques could not be read, and the answer says why."""
    places = [(kind.name, place) for kind in SERVO_EFFECTS.values() for place in kind.components]
    untested = [*outside.not_testable, *(NotTestable.of(*place, why) for place in places)]
    return outside.model_copy(update={"not_testable": untested, "not_read": [why]})


def joined(torques: Diagnosis, outside: Diagnosis) -> Diagnosis:
    """Findings of both; figures and pictures are those of the part that found more."""
    first, second = (
        (torques, outside) if _weight(torques) >= _weight(outside) else (outside, torques)
    )
    untested = [one for one in outside.not_testable if one.effect not in SERVO_EFFECTS]
    return first.model_copy(
        update={
            "verdict": _verdict([torques.verdict, outside.verdict]),
            # Two looks at one machine: the smaller p by chance is likelier.
            "false_alarm_p": min(1.0, 2.0 * min(torques.false_alarm_p, outside.false_alarm_p)),
            "findings": [*first.findings, *second.findings],
            "not_testable": [*torques.not_testable, *untested],
            "smallest_detectable": [*torques.smallest_detectable, *outside.smallest_detectable],
            "loosely_built": outside.loosely_built,
            "allowed_for": outside.allowed_for,
            "next_experiment": outside.next_experiment,
        }
    )


def _weight(answer: Diagnosis) -> tuple[bool, float]:
    return bool(answer.findings), sum(finding.evidence.delta_chi2 for finding in answer.findings)


def _verdict(both: Sequence[Verdict]) -> Verdict:
    told = {one for one in both if one != "nothing_missing"}
    if not told:
        return "nothing_missing"
    return told.pop() if len(told) == 1 else "partly_explained"
