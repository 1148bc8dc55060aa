"""The answer of a diagnosis as a notebook has it: a screen of text, a table, a drawing, files."""

from __future__ import annotations

import html
import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deltactl.foundation.extras import needs
from deltactl.interface import older
from deltactl.interface.recordings import AnyPath, Columns, Recording, tables_of
from deltactl.interface.robots import Robot, robot_of

if TYPE_CHECKING:
    import pandas as pd

    from deltactl.diagnosis.answer.finding import Finding, ParameterResult
    from deltactl.diagnosis.answer.records import Diagnosis as Answer
    from deltactl.diagnosis.answer.records import NextExperiment
    from deltactl.interface.figure import Figure

AnyRecording = AnyPath | Recording
FINDING_COLUMNS = [
    *("name", "component", "parameter", "size", "interval_low", "interval_high", "unit"),
    *("probability", "share", "says"),
]


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What differs between recordings and a robot file; `print` shows it on one screen.

    Attributes
    ----------
    answer : Record
        Every number, as the JSON contract has them.
    robot : Robot
        The robot file that the recordings were compared with.

    Examples
    --------
    >>> import deltactl as dc
    >>> import numpy as np, pandas as pd
    >>> t = np.arange(0.0, 20.0, 0.02)
    >>> asked = 0.04 * np.sin(0.8 * t) + 0.015 * np.sin(2.1 * t)
    >>> seen = 1.02 * asked + np.random.default_rng(3).normal(0.0, 1e-5, len(t))
    >>> frame = pd.DataFrame({"t": t, "command": asked, "position": seen})
    >>> slide = dc.Robot.from_text("{kind: servo_axis, name: slide, motion: linear}")
    >>> diagnosis = dc.diagnose(dc.Recording.from_pandas(frame), slide)
    >>> diagnosis.verdict
    'explained'
    >>> diagnosis.findings[["name", "component"]].values.tolist()
    [['gear_ratio', 'axis']]
    >>> diagnosis.corrected_robot()
    Robot('slide': servo_axis, known effects: gear_ratio axis)
    """

    answer: Answer
    robot: Robot

    @property
    def verdict(self) -> str:
        """ "nothing_missing", "explained", "partly_explained" or "unexplained"."""
        return str(self.answer.verdict)

    @property
    def findings(self) -> pd.DataFrame:
        """A finding in each row, the most important first.

        Columns: `name` of the effect, `component`, `parameter`, its `size`, `interval_low` and
        `interval_high` (95 %) in `unit`, `probability` that the effect acts, `share` of the
        model error that comes back without it, and `says`, one sentence. The size is that of the
        effect's main parameter; `sizes` has all of them. Raises MissingExtra without pandas.
        """
        rows = [
            (
                *(found.effect, found.component),
                *(next(_sizes(found), ("", math.nan, math.nan, math.nan, ""))),
                *(found.probability, found.share_of_mismatch, found.says),
            )
            for found in self.answer.findings
        ]
        return _frame(rows, FINDING_COLUMNS)

    @property
    def sizes(self) -> pd.DataFrame:
        """Every size of every finding, a row each; `finding` counts them from 1."""
        rows = [
            (number, found.effect, found.component, *size)
            for number, found in enumerate(self.answer.findings, 1)
            for size in _sizes(found)
        ]
        return _frame(rows, ["finding", *FINDING_COLUMNS[:7]])

    @property
    def next_experiment(self) -> NextExperiment | None:
        """The safe run that would tell the explanations apart; None where there is none.

        `simulate` takes its `job`, a mapping as a job file has it.
        """
        return self.answer.next_experiment

    def summary(self) -> str:
        """All sentences of the answer as plain text; `str` is what one screen has room for."""
        from deltactl.diagnosis.report.screen import sentences
        from deltactl.diagnosis.report.templates import PYTHON

        return "\n".join(sentences(self.answer, self.robot.model, PYTHON))

    def plot(self) -> Figure:
        """Draw the model error over time, before and after the findings, a panel for each reading.

        Returns
        -------
        Figure
            Shown by a notebook; `save` writes an SVG file, `svg` is its text.
        """
        from deltactl.interface.figure import Figure

        return Figure.of(self.answer)

    def to_json(self) -> dict[str, Any]:
        """The JSON object of the contract, which `deltactl diagnose --json` writes."""
        return self.answer.to_json()

    def save_report(self, path: AnyPath) -> None:
        """Write the HTML report. Raises RecordingError when it cannot be written."""
        from deltactl.diagnosis.report.page import Origin, write_report
        from deltactl.diagnosis.report.templates import PYTHON

        origin = Origin(str(self.robot.path))
        write_report(self.answer, self.robot.model, Path(path), PYTHON, origin)

    def corrected_robot(self, all_of_them: bool = False) -> Robot:
        """The robot with the findings that are certain among its known effects.

        Parameters
        ----------
        all_of_them : bool, optional
            Also those that are not certain.

        Returns
        -------
        Robot
            Its `save` writes the file. Where no finding is certain it is the same robot, which a
            warning says.
        """
        from deltactl.diagnosis.answer.corrected_robot import corrected_text

        text = corrected_text(self.robot.document, self.answer, all_of_them)
        if self.answer.findings and text == self.robot.text:
            advice = "" if all_of_them else "; all_of_them=True takes those that are not"
            warnings.warn(f"nothing is corrected: no finding is certain{advice}", stacklevel=2)
        return Robot.from_text(text, str(self.robot.path))

    def save_robot(self, path: AnyPath, replace: bool = False) -> None:
        """Use `corrected_robot().save(path)`; this name goes."""
        older("Diagnosis.save_robot(path)")
        self.corrected_robot().save(path, replace)

    def __str__(self) -> str:
        from deltactl.diagnosis.report.screen import screen_lines
        from deltactl.diagnosis.report.templates import PYTHON

        return "\n".join(screen_lines(self.answer, self.robot.model, PYTHON))

    def __repr__(self) -> str:
        known = ", ".join(f"{found.effect} {found.component}" for found in self.answer.findings)
        return f"Diagnosis({self.verdict}: {known or 'no findings'})"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def diagnose(
    recordings: AnyRecording | Sequence[AnyRecording],
    robot: AnyPath | Robot,
    *,
    holdout: AnyRecording | Sequence[AnyRecording] = (),
    columns: Columns | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find out where recordings and the robot file differ, and why.

    Parameters
    ----------
    recordings : Recording, path, or sequence of them
        Recordings of one machine.
    robot : Robot or path
        The machine as it should be. A plain name is also looked for among the files of the
        package.
    holdout : Recording, path, or sequence of them, optional
        Recordings that take no part in the search; the answer is tested on them.
    columns : mapping, optional
        How files that are given as paths are read, as in `read`.
    progress : callable, optional
        Gets a few words whenever another part of the work begins.

    Returns
    -------
    Diagnosis

    Raises
    ------
    ConfigError, MissingFile, RecordingError
        One line that says what is wrong, where, and what to do.
    MissingExtra
        The extra `diagnosis` is not installed.
    """
    with needs("diagnosis", "diagnose"):
        from deltactl.diagnosis.api import diagnose as answer_of

    compared_with = robot_of(robot)
    used = tables_of(recordings, columns)
    held_out = tables_of(holdout, columns, used)
    tables = used | held_out
    answer = answer_of(
        list(used),
        compared_with.document,
        list(held_out),
        progress=progress,
        read=tables.__getitem__,
    )
    return Diagnosis(answer, compared_with)


Size = tuple[str, float, float, float, str]
"""Parameter, value, ends of its interval, unit."""


def _sizes(finding: Finding) -> Iterator[Size]:
    """Its sizes, the main one first; of a vector one a component."""
    from deltactl.diagnosis.report.remedies import main_of

    if not finding.parameters:
        return
    main = main_of(finding)
    for name in sorted(finding.parameters, key=lambda name: name != main):
        yield from _components(name, finding.parameters[name])


def _components(name: str, result: ParameterResult) -> Iterator[Size]:
    several = isinstance(result.value, list)
    for number, (value, low, high) in enumerate(result.components):
        yield f"{name}[{number}]" if several else name, value, low, high, result.unit


def _frame(rows: Sequence[tuple[Any, ...]], columns: list[str]) -> pd.DataFrame:
    with needs("diagnosis", "findings"):
        import pandas as pd

    return pd.DataFrame(rows, columns=columns)


def __getattr__(name: str) -> Any:
    if name != "Answer":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    older("Answer", 2)
    return Diagnosis
