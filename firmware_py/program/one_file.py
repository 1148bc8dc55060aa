"""A job file read by itself, and the mistakes of all the files that it leads to."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from deltactl.firmware_py.file_access import FileAccess, without_quoting
from deltactl.firmware_py.job_file import JobFile, job_in
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.program.names_used import wrong_names
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.strict_yaml import Document

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
    """Of a job, of what it includes and, of the outermost, of its robot; each file once."""
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
        return  # told already
    data = document.data
    names = () if document.is_long else dict.fromkeys(_included(data.get("steps")))
    for name in islice(names, MOST_LOOKED_INTO):
        try:
            inner = find(name, path, listing=how.follow)
        except MissingFile:
            continue  # told already, with its line
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
