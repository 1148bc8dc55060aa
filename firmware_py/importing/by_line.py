"""What is wrong with a job that was made of a file, told by the line of that file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from deltactl.firmware_py.importing.drawn import Drawn, Point
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.path_file import Way, legs_of
from deltactl.firmware_py.paths.way import way
from deltactl.foundation.errors import ConfigError, MotionError
from deltactl.foundation.strict_yaml import Document

_LEG = re.compile(r"\blegs\.(\d+)")
_BEGIN = re.compile(r"\bstart_m\.\d+: ")
START = "where the path begins"


@contextmanager
def told_by_line(source: Path, drawn: Drawn, job: Path, text: str) -> Iterator[None]:
    """Refusals of the job (its text as it was made) name the line of `source` that is to blame."""
    try:
        yield
    except MotionError as error:
        wrong = error.at_point
        if wrong is not None and wrong.point == 0 and drawn.start_line is not None:
            raise error.worded(f"{source}:{drawn.start_line}: {START}: {wrong.says()}") from error
        leg = None if wrong is None or wrong.point is None else _leg_at(job, text, wrong.point)
        if wrong is None or leg is None:
            raise
        way_to = "on the way to the end of " if wrong.on_the_way else ""
        raise error.worded(
            f"{_line(source, drawn, leg)}: {way_to}this move: {wrong.says()}"
        ) from error
    except ConfigError as error:
        raise ConfigError(*(_named(source, drawn, str(one)) for one in error.args)) from error


def _leg_at(job: Path, text: str, point: int) -> int | None:
    """The leg that leads to a point of the path, from 0."""
    spec = Document(job, text).check(JobFile).path
    assert isinstance(spec, Way)
    assert spec.start_m is not None
    path = way(np.array(spec.start_m), legs_of(spec), spec.corner_m, spec.spacing_m)
    if path.leg is None or not 0 <= point < len(path):
        return None
    return int(path.leg[point])


def _named(source: Path, drawn: Drawn, says: str) -> str:
    if _BEGIN.search(says) and drawn.start_line is not None:
        return f"{source}:{drawn.start_line}: the path begins {_beyond(drawn.start_m)}"
    found = _LEG.search(says)
    if found is None:
        return says
    leg, wrong = int(found[1]), says[found.end() :].lstrip(".: ")
    if wrong.startswith("to_m") and leg < len(drawn.legs):
        wrong = f"this move ends {_beyond(drawn.legs[leg]['to_m'])}"
    return f"{_line(source, drawn, leg)}: {wrong}"


def _beyond(place_m: Point) -> str:
    place = " ".join(f"{1e3 * value:.6g}" for value in place_m)
    return f"at {place} mm, beyond the reach of any arm; are the units right?"


def _line(source: Path, drawn: Drawn, leg: int) -> str:
    return (
        f"{source}:{drawn.lines[leg]}" if leg < len(drawn.lines) else f"{source}, point {leg + 2}"
    )
