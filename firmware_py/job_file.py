"""A job file: robot, path or steps, timing, inverse kinematics, repeats, its recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from deltactl.drivers.settings import Name
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.path_file import Dwell, Joints, PathSpec, StraightTo, Way
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.explain import Mistake
from deltactl.foundation.strict_yaml import Document, RuledModel, StrictModel, rule, valid_keys_of
from deltactl.models.robot import KINDS

SLOWEST_MPS, FASTEST_MPS = 1e-6, 10.0


class Together(StrictModel):
    """All motors step together, one tick every T_PWM, as in Zhao 2023. There are no ramps."""

    mode: Literal["together"] = "together"
    t_pwm_s: Annotated[
        float, Field(ge=50e-6, le=10.0, description="the pulse process is good for 50 us and up")
    ]


class Accelerated(RuledModel):
    """Every motor keeps its own speed and acceleration limit; the path slows down where it must."""

    mode: Literal["accelerated"]
    speed_mps: (
        Annotated[float, Field(ge=SLOWEST_MPS, le=FASTEST_MPS, description="m/s; 1 um/s to 10 m/s")]
        | None
    ) = None
    """Speed of the platform along the path wherever the limits allow it."""
    duration_s: (
        Annotated[float, Field(ge=0.01, le=86400.0, description="seconds; a day at most")] | None
    ) = None
    """In place of a speed: how long each repeat takes from leaving the first target, with the
    rests at the others and the way back to its start. Refused, with the shortest time there is,
    where the limits do not allow it."""
    joint_speed_radps: (
        Annotated[float, Field(ge=1e-5, le=1e3, description="rad/s, a turn a week to 160 a second")]
        | None
    ) = None
    """Not above the robot file's limit; absent for that limit. So too the acceleration."""
    joint_acceleration_radps2: (
        Annotated[float, Field(ge=1e-4, le=1e5, description="rad/s2; beyond is a blow")] | None
    ) = None

    @rule("speed_mps", "duration_s")
    def _either(self) -> None:
        if (self.speed_mps is None) == (self.duration_s is None):
            raise ValueError("give either 'speed_mps' or 'duration_s'")


def mode(timing: Any) -> Any:
    """The mode that a `timing` section asks for; without one all motors step together."""
    if isinstance(timing, dict):
        return timing.get("mode", "together")
    return getattr(timing, "mode", "together")


Timing = Annotated[
    Annotated[Together, Tag("together")] | Annotated[Accelerated, Tag("accelerated")],
    Discriminator(mode),
]


MANY = "weeks of work at most"
FileName = Annotated[str, Field(min_length=1, max_length=1000)]


class PathStep(StrictModel):
    """Follow a path, from rest to rest."""

    path: PathSpec
    """A `way` without `start_m` begins where the path before it ended."""
    timing: Timing | None = None
    """Absent: the job's."""


class SetStep(StrictModel):
    """Switch outputs of the robot file."""

    set: Annotated[dict[Name, bool], Field(min_length=1, description="name an output")]
    """`{gripper: on}`."""


class WaitStep(StrictModel):
    """Wait at rest."""

    wait_s: Dwell


class Awaited(StrictModel):
    """An input, and how long to wait for it."""

    input: Name
    """One of `inputs.named` of the robot file."""
    is_on: bool = True
    """Or until it is off."""
    within_s: Annotated[float, Field(gt=0.0, le=86_400.0, description="seconds, at most a day")]
    """When it has not come by then, the job is cancelled."""


class WaitForStep(StrictModel):
    """Wait at rest until an input is on, or off."""

    wait_for: Awaited


class PauseStep(StrictModel):
    """Wait at rest for `resume`: a hand may be in the machine."""

    pause: Annotated[
        str, Field(min_length=1, max_length=200, description="says in one line why somebody waits")
    ]
    """Why, for whoever is to resume."""


class IncludeStep(StrictModel):
    """Another job file, for the same robot: its path or steps, timing and kinematics."""

    include: FileName
    """Sought beside this job and in `config/`."""


class GeometryIk(StrictModel):
    """Closed-form inverse kinematics of the robot file's geometry and known effects."""

    kind: Literal["geometry"]


class NetworkIk(StrictModel):
    """A TFLite network; its file names the robot it was trained for."""

    kind: Literal["network"]
    file: FileName
    """Sought beside the job, in `config/` and in `models/trained/`."""


class CalibratedIk(StrictModel):
    """As `geometry`, and refused when the robot file knows of no effect that it could correct."""

    kind: Literal["calibrated"]


KinematicsSpec = Annotated[GeometryIk | NetworkIk | CalibratedIk, Field(discriminator="kind")]
Repeats = Annotated[int, Field(ge=1, le=100_000, description=MANY)]


class InnerJob(StrictModel):
    """What an `include` becomes in a recording, so that a recording holds its whole path."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    """That of the other file; so with all that follow."""
    path: PathSpec | None = None
    """One path, or `steps`."""
    steps: tuple[Step, ...] | None = None
    """In place of a path."""
    timing: Timing
    """As in a job file."""
    inverse_kinematics: KinematicsSpec
    """As in a job file."""
    repeats: Repeats = 1


class JobStep(StrictModel):
    """Another job, written out."""

    job: InnerJob


class RepeatStep(StrictModel):
    """Steps, so many times."""

    repeat: Repeats
    steps: Annotated[tuple[Step, ...], Field(min_length=1, description="repeat something")]


STEP_KINDS: dict[str, type[StrictModel]] = {
    "path": PathStep,
    "set": SetStep,
    "wait_s": WaitStep,
    "wait_for": WaitForStep,
    "pause": PauseStep,
    "include": IncludeStep,
    "job": JobStep,
    "repeat": RepeatStep,
}
"""The key that says what a step is."""


def step(value: Any) -> Any:
    """What a step is, by its first key that says so."""
    if isinstance(value, dict):
        return next((key for key in value if key in STEP_KINDS), None)
    return next((key for key, kind in STEP_KINDS.items() if isinstance(value, kind)), None)


Step = Annotated[
    Annotated[PathStep, Tag("path")]
    | Annotated[SetStep, Tag("set")]
    | Annotated[WaitStep, Tag("wait_s")]
    | Annotated[WaitForStep, Tag("wait_for")]
    | Annotated[PauseStep, Tag("pause")]
    | Annotated[IncludeStep, Tag("include")]
    | Annotated[JobStep, Tag("job")]
    | Annotated[RepeatStep, Tag("repeat")],
    Discriminator(step),
]
InnerJob.model_rebuild()
RepeatStep.model_rebuild()
JobStep.model_rebuild()


__all__ = ["Accelerated", "CalibratedIk", "GeometryIk", "JobFile", "NetworkIk", "Together"]


class JobFile(StrictModel):
    """One job: a `path`, or `steps`. Named files are sought beside the job, then in the project."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    """What recordings and reports call it."""
    robot: Annotated[str, Field(min_length=1, max_length=1000)]
    """The file of the robot that it is for."""
    path: PathSpec | None = None
    """One path, and nothing else; or give `steps`."""
    steps: Annotated[tuple[Step, ...], Field(min_length=1, description="do something")] | None = (
        None
    )
    """In place of a path: paths, outputs, waits, repeats and other jobs, one after another."""
    timing: Timing
    """All motors together, or each as fast as its limits allow."""
    inverse_kinematics: KinematicsSpec
    """How targets become angles of the arms."""
    repeats: Repeats = 1
    """Each repeat begins and ends at rest; an open path is returned to its start between them."""
    record: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """Name of the recording in the folder of recordings; absent: `<name>-<date>.mcap`."""
    on_step_loss: Literal["stop", "warn"] = "stop"
    """What happens when the sensors show that steps were lost."""
    feedback: FeedbackSettings | None = None
    """Correct by the sensors what goes wrong while the job runs, as lost steps; absent: no. Then
    steps that the sensors see to be lost are corrected, and `on_step_loss` stops nothing."""
    on_blind: Literal["stop", "warn"] = "stop"
    """What happens when the sensors do not show the arms for half a second."""

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> JobFile:
        for _, says in _clashes(dict(self)):
            raise ValueError(says)
        return self


def _clashes(sections: Mapping[str, Any]) -> Iterator[Mistake]:
    """Where sections that are right by themselves contradict each other."""
    path, timing = sections.get("path"), sections.get("timing")
    of_steps = "path" in sections and path is None
    if of_steps and isinstance(timing, Accelerated) and timing.duration_s is not None:
        yield ("timing",), "duration_s is for one path; a job of steps needs speed_mps"
    if {"path", "steps"} <= sections.keys() and (path is None) == (sections["steps"] is None):
        yield (), "give either 'path' or 'steps'"
    if isinstance(path, StraightTo) and getattr(timing, "speed_mps", None) is None:
        yield ("timing",), "a straight path needs timing mode accelerated with speed_mps"
    if not isinstance(path, Way):
        return
    if path.start_m is None:
        yield ("path",), "start_m is missing: only in 'steps' a way may go on from another"
    if isinstance(timing, Together) and np.isfinite(path.legs.speed_mps).any():
        yield ("timing",), "legs with speed_mps need timing mode accelerated"


def way_in_mps(job: JobFile) -> float | None:
    """How fast a job is that has no path but its way in: straight to a place, or to one pose.

    None for every other job: its way in is as slow as the robot file says.
    """
    one = isinstance(job.path, StraightTo) or (
        isinstance(job.path, Joints) and len(job.path.angles_deg) == 1
    )
    return job.timing.speed_mps if one and isinstance(job.timing, Accelerated) else None


def load_job(path: Path) -> JobFile:
    """Read a job file. Raises MissingFile or ConfigError (one line)."""
    return job_in(Document.read(path))


def job_in(document: Document) -> JobFile:
    """The job of a file that was read. Raises ConfigError (a line for each mistake)."""
    if document.data.get("kind") in KINDS and "robot" not in document.data:
        raise document.fail(
            ("kind",),
            f"describes a robot, and a job is needed here; one says 'robot: {document.path.name}'"
            " and what to do (docs/jobs.md; 'deltactl init delta' writes a first one)",
        )
    try:
        return document.check(JobFile)
    except ConfigError as error:
        if document.is_long:
            raise
        data = document.data
        sections = valid_keys_of(JobFile, data)
        if "path" in data and "steps" in data:
            sections |= {"path": data["path"], "steps": data["steps"]}
        clashes = list(_clashes(sections))
        mistakes = [m for m in error.args if not any(m.endswith(says) for _, says in clashes)]
        others = [str(document.fail(*one)) for one in clashes]
        raise ConfigError(*mistakes, *others) from None
