"""A job: robot, path or steps, timing, inverse kinematics, repeats, and where it is recorded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.job_steps import (
    CalibratedIk,
    GeometryIk,
    KinematicsSpec,
    NetworkIk,
    Repeats,
    Step,
)
from deltactl.firmware_py.job_timing import Accelerated, Timing, Together
from deltactl.firmware_py.path_file import Joints, PathSpec, StraightTo, Way
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.explain import Mistake
from deltactl.foundation.strict_yaml import Document, StrictModel, valid_keys_of
from deltactl.models.robot import KINDS

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
            " and what to do (docs/jobs.md; 'deltactl init' writes a first one)",
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
