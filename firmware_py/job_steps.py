"""Steps of a job that is more than one path: paths, outputs, waits, repeats, and other jobs."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from deltactl.drivers.settings import Name
from deltactl.firmware_py.job_timing import Timing
from deltactl.firmware_py.path_file import Dwell, PathSpec
from deltactl.foundation.strict_yaml import StrictModel

MANY = "weeks of work at most"
FileName = Annotated[str, Field(min_length=1, max_length=1000)]


class PathStep(StrictModel):
    """Follow a path; the arms stand at its beginning and at its end."""

    path: PathSpec
    """A `way` without `start_m` begins where the path before it ended."""
    timing: Timing | None = None
    """Absent: the job's."""


class SetStep(StrictModel):
    """Switch outputs of the robot file."""

    set: Annotated[dict[Name, bool], Field(min_length=1, description="name an output")]
    """`{gripper: on}`."""


class WaitStep(StrictModel):
    """Stand and wait."""

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
    """Stand until an input is on, or off."""

    wait_for: Awaited


class PauseStep(StrictModel):
    """Stand until somebody says `resume`: a hand may be in the machine."""

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


KINDS: dict[str, type[StrictModel]] = {
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
        return next((key for key in value if key in KINDS), None)
    return next((key for key, kind in KINDS.items() if isinstance(value, kind)), None)


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
