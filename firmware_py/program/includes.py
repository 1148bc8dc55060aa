"""Jobs that include others, read whole: a job always holds everything it does.

In: a job file. Out: the job, and its text with every `include` written out as a `job`; or the
mistakes of all the files that it leads to.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import yaml

from deltactl.firmware_py.file_access import FileAccess, without_quoting
from deltactl.firmware_py.job_file import (
    IncludeStep,
    InnerJob,
    JobFile,
    JobStep,
    KinematicsSpec,
    PathStep,
    RepeatStep,
    job_in,
)
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.path_file import PathSpec
from deltactl.firmware_py.program.names_used import wrong_names
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.strict_yaml import Document

DEEPEST = 8
MOST_INCLUDED = 1000
OUTER_ONLY = ("feedback", "record")
"""Keys of a job that only the outermost can have; so too on_step_loss and on_blind."""


@dataclass(frozen=True, slots=True)
class WholeJob:
    """A job, and the text that says all of it."""

    job: JobFile
    text: str


def read_whole(
    path: Path, how: FileAccess | None = None, robot: RobotFile | None = None
) -> WholeJob:
    """Read a job file and all that it includes. Raises MissingFile, ConfigError (file and line).

    robot: whose outputs and inputs it names, where that is not the robot of its file.
    """
    how = how or FileAccess()
    try:
        if robot is not None:
            return _read_whole(path, how, robot)
        return how.once("whole job", path, lambda: _read_whole(path, how, None))
    except ConfigError as error:
        raise with_those_of_all(error, path, how, robot) from None


def _read_whole(path: Path, how: FileAccess, robot: RobotFile | None) -> WholeJob:
    document, job = read_one(path, how, robot)
    if not any(isinstance(one, IncludeStep) for one in _flat(job.steps or ())):
        return WholeJob(job, document.text)
    reader = _Reader(how, job.robot, path, robot)
    whole = dict(document.data) | {"steps": reader.steps(document, (path.resolve(),))}
    text = yaml.dump(whole, Dumper=_WithoutAliases, sort_keys=False, allow_unicode=True)
    written_out = Document(path, text)
    return WholeJob(written_out.check(JobFile), text)


def paths_of(job: JobFile) -> Iterator[PathSpec]:
    """Every path of a job, those of its steps as often as they are written."""
    if job.path is not None:
        yield job.path
    for one in _flat(job.steps or ()):
        if isinstance(one, PathStep):
            yield one.path
        elif isinstance(one, JobStep) and one.job.path is not None:
            yield one.job.path


def kinematics_in(job: JobFile | InnerJob) -> list[KinematicsSpec]:
    """What its paths are mapped with, each once: an included job brings its own."""
    found: list[KinematicsSpec] = []
    if job.path is not None:
        found.append(job.inverse_kinematics)
    for one in _flat(job.steps or (), inner=False):
        if isinstance(one, PathStep):
            found.append(job.inverse_kinematics)
        elif isinstance(one, JobStep):
            found.extend(kinematics_in(one.job))
    return [one for place, one in enumerate(found) if one not in found[:place]]


def _flat(steps: Sequence[Any], inner: bool = True) -> Iterator[Any]:
    """Steps and those in them; inner: those of other jobs as well."""
    for one in steps:
        yield one
        if isinstance(one, RepeatStep):
            yield from _flat(one.steps, inner)
        elif inner and isinstance(one, JobStep):
            yield from _flat(one.job.steps or ())


class _WithoutAliases(yaml.SafeDumper):
    """Writes a job that is included twice out twice."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _Reader:
    """Writes out the includes of one job file."""

    def __init__(self, how: FileAccess, robot: str, outermost: Path, given: RobotFile | None):
        self._how, self._given = how, given
        self._robot, self._outermost = robot, outermost
        self._included = 0

    def steps(self, document: Document, above: tuple[Path, ...]) -> list[Any]:
        """The steps of a file as plain values; above: the files that led here, it the last."""
        return self._list(document, ("steps",), document.data["steps"], above)

    def _list(
        self, document: Document, place: tuple[str | int, ...], steps: Any, above: tuple[Path, ...]
    ) -> list[Any]:
        made = []
        for number, one in enumerate(steps):
            here = (*place, number)
            if "include" in one:
                made.append({"job": self._include(document, here, one["include"], above)})
            elif "repeat" in one:
                inner = self._list(document, (*here, "steps"), one["steps"], above)
                made.append(dict(one) | {"steps": inner})
            elif "job" in one and "steps" in one["job"]:
                inner = self._list(document, (*here, "job", "steps"), one["job"]["steps"], above)
                made.append({"job": dict(one["job"]) | {"steps": inner}})
            else:
                made.append(one)
        return made

    def _include(
        self, document: Document, place: tuple[str | int, ...], name: str, above: tuple[Path, ...]
    ) -> dict[str, Any]:
        place = (*place, "include")
        path = find(name, document.path, listing=self._how.follow)
        self._included += 1
        if path.resolve() in above:
            raise document.fail(place, f"{name} includes itself")
        if len(above) >= DEEPEST or self._included > MOST_INCLUDED:
            raise document.fail(
                place, f"jobs include each other more than {DEEPEST} deep, or too often"
            )
        inner, job = read_one(path, self._how.named, self._given)
        self._check_fits(inner, job)
        kept = ("name", "path", "timing", "inverse_kinematics", "repeats")
        values = {key: inner.data[key] for key in kept if key in inner.data}
        if job.steps is not None:
            values["steps"] = self.steps(inner, (*above, path.resolve()))
        return _with_found_network(values, path)

    def _check_fits(self, document: Document, job: JobFile) -> None:
        for key in OUTER_ONLY:
            if getattr(job, key) is not None:
                raise document.fail((key,), "an included job cannot have this; move it outwards")
        if job.robot == self._robot:
            return
        robots = (
            find(job.robot, document.path, listing=self._how.follow),
            find(self._robot, self._outermost, listing=self._how.follow),
        )
        if robots[0].resolve() != robots[1].resolve():
            raise document.fail(
                ("robot",), f"is not {self._robot}, the robot of the job that includes this"
            )


def _with_found_network(values: dict[str, Any], path: Path) -> dict[str, Any]:
    """A network beside the included job is not beside the job that includes it."""
    chosen = values["inverse_kinematics"]
    file = chosen.get("file")
    if file and (path.parent / file).is_file():
        values["inverse_kinematics"] = chosen | {"file": str((path.parent / file).resolve())}
    return values


MOST_LOOKED_INTO = 100
"""Files of a job with mistakes; their mistakes are more than anybody reads."""


def job_of(path: Path, how: FileAccess) -> JobFile:
    """A job as its own file says it, checked once. Raises MissingFile, ConfigError."""
    return how.once("job", path, lambda: job_in(how.document(path)))


def read_one(path: Path, how: FileAccess, robot: RobotFile | None) -> tuple[Document, JobFile]:
    """A job without what it includes. Raises MissingFile, ConfigError (a line for each mistake)."""
    with without_quoting(path, how):
        document = how.document(path)
        names = wrong_names(document, how, robot)
        try:
            job = job_of(path, how)
        except ConfigError as error:
            raise ConfigError(*error.args, *document.fail_all(names).args) from None
        if names:
            raise document.fail_all(names)
        return document, job


def with_those_of_all(
    error: ConfigError, path: Path, how: FileAccess, robot: RobotFile | None
) -> ConfigError:
    """What is wrong in a job, and beside it what is wrong in the files it names.

    Of a job that is not there, and of a text that nobody may quote, it is `error` itself.
    """
    if isinstance(error, MissingFile) or not how.quote:
        return error
    found = list(error.args)
    for each in _mistakes(path, how, robot, set()):
        found += [one for one in each.args if one not in found]
    return ConfigError(*found)


def _mistakes(
    path: Path, how: FileAccess, robot: RobotFile | None, seen: set[Path]
) -> Iterator[ConfigError]:
    """Mistakes of a job, of its includes and, for the outermost, of its robot; each file once."""
    outermost = not seen
    seen.add(path.resolve())
    if not outermost:  # its mistakes are known already
        try:
            read_one(path, how, robot)
        except ConfigError as error:
            yield error
    try:
        with without_quoting(path, how):
            document = how.document(path)
    except ConfigError:
        return  # reported already
    data = document.data
    names = () if document.is_long else dict.fromkeys(_included(data.get("steps")))
    for name in islice(names, MOST_LOOKED_INTO):
        try:
            inner = find(name, path, listing=how.follow)
        except MissingFile:
            continue  # reported already, with its line
        if inner.resolve() not in seen and len(seen) < MOST_LOOKED_INTO:
            yield from _mistakes(inner, how.named, robot, seen)
    if outermost and robot is None and how.named.quote and isinstance(data.get("robot"), str):
        try:
            how.robot(find(data["robot"], path, listing=how.follow))
        except ConfigError as error:
            yield error


def _included(steps: Any) -> Iterator[str]:
    """The files that steps name, however wrong the steps are."""
    for one in steps if isinstance(steps, list) else ():
        if not isinstance(one, dict):
            continue
        name, inner = one.get("include"), one.get("job")
        if isinstance(name, str) and not Path(name).is_absolute() and ".." not in Path(name).parts:
            yield name
        yield from _included(one.get("steps"))
        yield from _included(inner.get("steps") if isinstance(inner, dict) else None)
