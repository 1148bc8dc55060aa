"""The ways from an admitted machine to its answer: a delta, an axis, a sensor, a servo robot.

A servo robot is looked at in two parts: torques by the disturbances, geometry by the sensors. The
encoders say where the arms were, so sensors are compared with the measured angles, not with what
was asked for; what following costs is the torques' business.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from deltactl.diagnosis.admission.admit import Admission, Machine, ServoRobot
from deltactl.diagnosis.admission.axis_match import check_together, too_large
from deltactl.diagnosis.answer.records import Diagnosis, NotTestable, Picture, Verdict
from deltactl.diagnosis.experiment.next_motion import next_motion
from deltactl.diagnosis.experiment.propose import Proposal, next_run
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.pipelines.regression import NextRun, diagnose_plant
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.diagnosis.plants.chain.poses import PosePlant
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.servo_delta import CHANNEL, ServoDelta
from deltactl.diagnosis.progress import Progress
from deltactl.diagnosis.report.in_words import in_words, kinds_of
from deltactl.diagnosis.selection.named_first import Selected
from deltactl.models.effects.chain_joints import chain_effects
from deltactl.models.effects.kind import MOTORS
from deltactl.models.effects.lone_axis import command_effects
from deltactl.models.effects.servo_joints import SERVO_EFFECTS
from deltactl.models.robot import ChainRobot, DeltaRobot, ServoAxis


def diagnosed(
    admission: Admission,
    progress: Progress = lambda _: None,
    limits: MotionLimits | None = None,
) -> Diagnosis:
    """The answer, by the kind of machine. Raises RefusedRecording for what was not admitted.

    limits: for the run that is proposed.
    """
    machine = admission.passed()
    if isinstance(machine, ServoRobot):
        return _servo(machine, progress, limits)
    if isinstance(machine, dict):
        return joined([_at(name, _answered(one, progress)) for name, one in machine.items()])
    if isinstance(machine.plant, DeltaPlant):
        return _delta(machine, progress, limits)
    if isinstance(machine.plant, ServoDelta):
        return _joints(machine, progress)
    if isinstance(machine.plant, ChainPlant):
        return _chain(machine, progress)
    if isinstance(machine.plant, PosePlant):
        return _posed(machine, progress)
    return _axis(admission, machine, progress)


def _delta(machine: Machine, progress: Progress, limits: MotionLimits | None) -> Diagnosis:
    def runs(selected: Selected) -> Proposal:
        near = selected.plant
        assert isinstance(near, DeltaPlant)
        return next_run(near, selected.posterior.explanations, limits)

    return _answered(machine, progress, runs)


def _servo(machine: ServoRobot, progress: Progress, limits: MotionLimits | None) -> Diagnosis:
    """A servo delta: its geometry, and its joints where their torques could be read."""
    outside = _delta(machine.outside, progress, limits)
    if not isinstance(machine.torques, Machine):
        return _alone(outside, machine.torques.says)
    outside = in_words(outside)
    untested = [one for one in outside.not_testable if one.effect not in SERVO_EFFECTS]
    geometry = outside.model_copy(update={"not_testable": untested})
    whole = joined([_joints(machine.torques, progress), geometry])
    return whole.model_copy(update={name: getattr(outside, name) for name in OF_GEOMETRY})


def _answered(
    machine: Machine, progress: Progress, runs: NextRun = lambda _: Proposal(None)
) -> Diagnosis:
    """The engine's answer, with the recordings that could not be held out."""
    try:
        answer = diagnose_plant(machine, progress, runs)
    except OverflowError:
        raise too_large() from None
    left_out = [refusal.says for refusal in machine.left_out]
    return answer.model_copy(update={"not_held_out": left_out})


def _axis(admission: Admission, machine: Machine, progress: Progress) -> Diagnosis:
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


def _at(joint: str, answer: Diagnosis) -> Diagnosis:
    """The answer on an axis as that on a joint of an arm, in words."""

    def there(parts: Sequence[Any]) -> list[Any]:
        return [one.model_copy(update={"component": joint}) for one in parts]

    found = [
        one.model_copy(update={"alternatives": there(one.alternatives)}) for one in answer.findings
    ]
    moved = {
        "findings": there(found),
        "not_testable": there(answer.not_testable),
        "smallest_detectable": there(answer.smallest_detectable),
    }
    return in_words(answer.model_copy(update=moved), command_effects("rotary"))


def _joints(machine: Machine, progress: Progress) -> Diagnosis:
    """A servo delta by its disturbance estimates."""
    plant = machine.plant
    assert isinstance(plant, ServoDelta)
    answer = _answered(machine, progress)
    joints = len(MOTORS)
    t_s = plant.readings.t_s[: len(plant.readings.t_s) // joints]
    answer = _by_joint(answer, MOTORS, float(t_s[0]), plant.span_s, CHANNEL)
    pictured = _apart(answer, lambda column: column.reshape(joints, -1).T, t_s, channels=CHANNEL)
    return in_words(pictured, SERVO_EFFECTS)


def _chain(machine: Machine, progress: Progress) -> Diagnosis:
    """A chain of joints by its efforts."""
    plant = machine.plant
    assert isinstance(plant, ChainPlant)
    answer = _answered(machine, progress, partial(next_motion, plant))
    whole, chain = plant.moved.whole, plant.chain
    t_s, channel = whole.t_s[plant.layout.kept], plant.channel
    answer = _by_joint(answer, chain.joints, float(whole.t_s[0]), whole.span_s, channel)
    answer = _apart(answer, plant.layout.apart, t_s, channels=channel)
    kinds = chain_effects(dict(zip(chain.joints, chain.slides, strict=True)), chain.tip)
    return in_words(answer, kinds, plant.robot.effects)


def _posed(machine: Machine, progress: Progress) -> Diagnosis:
    """A chain of joints by places and orientations that were measured from outside."""
    plant = machine.plant
    assert isinstance(plant, PosePlant)
    answer = _answered(machine, progress)
    answer = _apart(answer, plant.layout.apart, plant.poses.t_s, names=plant.names)
    whole = float(plant.poses.t_s[0]), float(plant.poses.t_s[-1])
    answer = _seen_on(answer, lambda _: plant.names, times_s=[whole])
    slides = dict(zip(plant.joints, plant.chain.slides, strict=True))
    return in_words(answer, chain_effects(slides, plant.chain.tip), plant.robot.effects)


OF_GEOMETRY = ("loosely_built", "allowed_for", "next_experiment")
DRAWN = ("observed", "before", "after", "counted")
OF_A_JOINT = {"position": "theta", "velocity": "speed"}
"""Covariates of joints that are drawn, and what they are called with the number of a joint."""


def _apart(
    answer: Diagnosis,
    apart: Callable[[FloatArray], FloatArray],
    t_s: FloatArray,
    names: Sequence[str] = (),
    channels: str = "",
) -> Diagnosis:
    """The same with a channel for each column of what lay end to end, `apart` (samples, columns).

    names: of the channels; of joints their stem, and each has covariates of its own.
    """
    picture = answer.picture
    if picture is None:
        return answer
    (whole,) = picture.channels
    parts = {part: apart(getattr(whole, part)) for part in DRAWN}
    names = names or [f"{channels}_{j}" for j in range(1, parts["observed"].shape[1] + 1)]
    drawn = [
        whole.model_copy(update={"name": name, **{part: v[:, k] for part, v in parts.items()}})
        for k, name in enumerate(names)
    ]
    follows = {name: apart(values) for name, values in picture.covariates.items()}
    covariates = {
        f"{OF_A_JOINT[name]}_{j}": column
        for name in OF_A_JOINT
        if channels
        for j, column in enumerate(follows[name].T, 1)
    } or {name: values[:, 0] for name, values in follows.items()}
    made = Picture(t_s=t_s, channels=drawn, covariates=covariates)
    return answer.model_copy(update={"picture": made})


def _by_joint(
    answer: Diagnosis, joints: Sequence[str], first_s: float, span_s: float, channel: str
) -> Diagnosis:
    """Findings of joints that were end to end, each at its own, in the recording's own time."""
    each = {joint: [f"{channel}_{number}"] for number, joint in enumerate(joints, 1)}
    every = [name for (name,) in each.values()]
    whole = [(first_s, first_s + span_s)]
    return _seen_on(answer, lambda one: each.get(one, every), times_s=whole, recordings=[1])


def _seen_on(answer: Diagnosis, axes: Callable[[str], list[str]], **where: Any) -> Diagnosis:
    """Findings with the channels on which their component shows."""
    found = []
    for one in answer.findings:
        seen = one.where.model_copy(update={"axes": axes(one.component), **where})
        found.append(one.model_copy(update={"where": seen}))
    return answer.model_copy(update={"findings": found})


def _alone(outside: Diagnosis, why: str) -> Diagnosis:
    """Geometry only: the torques could not be read, and the answer says why."""
    places = [(kind.name, place) for kind in SERVO_EFFECTS.values() for place in kind.components]
    untested = [*outside.not_testable, *(NotTestable.of(*place, why) for place in places)]
    return outside.model_copy(update={"not_testable": untested, "not_read": [why]})


def joined(parts: Sequence[Diagnosis]) -> Diagnosis:
    """Findings of parts of one machine; figures and picture are those of the part that found most.

    A smaller p by chance is the likelier, the more parts are looked at.
    """
    first = max(parts, key=_weight)
    nothing = [one.probability_nothing_missing for one in parts]
    others = [found for one in parts if one is not first for found in one.findings]
    return first.model_copy(
        update={
            "verdict": _verdict([one.verdict for one in parts]),
            "false_alarm_p": min(1.0, len(parts) * min(one.false_alarm_p for one in parts)),
            "probability_nothing_missing": math.prod(p for p in nothing if p is not None),
            "findings": [*first.findings, *others],
            "not_testable": [no for one in parts for no in one.not_testable],
            "smallest_detectable": [size for one in parts for size in one.smallest_detectable],
        }
    )


def _weight(answer: Diagnosis) -> tuple[bool, float]:
    return bool(answer.findings), sum(finding.evidence.delta_chi2 for finding in answer.findings)


def _verdict(both: Sequence[Verdict]) -> Verdict:
    told = {one for one in both if one != "nothing_missing"}
    if not told:
        return "nothing_missing"
    return told.pop() if len(told) == 1 else "partly_explained"
