"""What a notebook or a script uses: `import deltactl`."""

from __future__ import annotations

import html
import time
from collections.abc import Mapping as AnyMapping
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs
from deltactl.models.robot import RobotModel
from deltactl.models.robot_files import load_with_effects
from deltactl.recording.tables.flat import FlatRecording

if TYPE_CHECKING:
    from deltactl.diagnosis.answer.finding import Finding
    from deltactl.diagnosis.answer.records import Diagnosis
    from deltactl.recording.foreign.found import Inspection

AnyPath = str | Path
POLL_S = 0.5
ANY_DEG = 360.0
"""Homing of a simulated robot puts the arms exactly where they count as homed."""


@dataclass(frozen=True)
class Answer:
    """The answer of a diagnosis; `print` shows it as the terminal does.

    diagnosis: every number; robot_file: the robot file it refers to.
    """

    diagnosis: Diagnosis
    robot_file: Path

    @property
    def verdict(self) -> str:
        """ "model_error", "no_model_error" or what else the contract lists."""
        return str(self.diagnosis.verdict)

    @property
    def findings(self) -> list[Finding]:
        """The effects found: name, component, sizes with intervals, probability."""
        return self.diagnosis.findings

    def to_json(self) -> dict[str, Any]:
        """The JSON object of the contract."""
        return self.diagnosis.to_json()

    def save_report(self, path: AnyPath) -> None:
        """Write the HTML report. Raises RecordingError when it cannot be written."""
        from deltactl.diagnosis.report.page import write_report

        write_report(self.diagnosis, load_with_effects(self.robot_file), Path(path))

    def save_robot(self, path: AnyPath, replace: bool = False) -> None:
        """Write the robot file with the findings that are certain. Raises RecordingError."""
        from deltactl.diagnosis.answer.corrected_robot import save_corrected

        save_corrected(self.robot_file, self.diagnosis, Path(path), replace=replace)

    def __str__(self) -> str:
        from deltactl.diagnosis.report.summary import plain_lines

        return "\n".join(plain_lines(self.diagnosis, load_with_effects(self.robot_file)))

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def diagnose(
    recordings: AnyPath | Sequence[AnyPath],
    robot: AnyPath,
    *,
    holdout: Sequence[AnyPath] = (),
    columns: AnyMapping[str, str] | None = None,
    thorough: bool = False,
) -> Answer:
    """Find out where recordings and the robot file differ, and why.

    Parameters
    ----------
    recordings : path or sequence of paths
        CSV, Parquet, MAT or MCAP files of one machine.
    robot : path
        The robot file: the machine as it should be. A name is also looked for in `config`.
    holdout : sequence of paths, optional
        Recordings that the answer is tested on.
    columns : mapping, optional
        Column and unit for each name of the contract, `{"position": "angle[deg]"}`, as `--set` of
        the command takes them.
    thorough : bool, optional
        Search without a limit of work.

    Raises
    ------
    ConfigError, MissingFile, RecordingError
        One line that says what is wrong, where, and what to do.
    """
    with needs("diagnosis", "diagnose"):
        from deltactl.diagnosis.api import diagnose as answer_of

    several = [recordings] if isinstance(recordings, str | Path) else list(recordings)
    robot_file = find(str(robot), key=ROBOT_KEY)
    found = answer_of(
        [Path(path) for path in several],
        robot_file,
        [Path(path) for path in holdout],
        read=lambda path: read_recording(path, columns),
        thorough=thorough,
    )
    return Answer(found, robot_file)


def inspect(recording: AnyPath, columns: AnyMapping[str, str] | None = None) -> Inspection:
    """Return what a table seems to hold: columns, units, rate and kind of machine.

    columns: those that are known already, as in `diagnose`. Raises RecordingError.
    """
    with needs("diagnosis", "inspect"):
        from deltactl.recording.foreign.inspection import inspect as look_at
        from deltactl.recording.foreign.mapping import load_mapping
    return look_at(Path(recording), load_mapping(None, _options(columns)) if columns else None)


def read_recording(
    recording: AnyPath, columns: AnyMapping[str, str] | None = None
) -> FlatRecording:
    """Read a recording into arrays in SI units: `t_s` (n,), and `columns` by name, (n,) each.

    columns: as in `diagnose`. Raises RecordingError or MissingFile.
    """
    from deltactl.recording.tables.flat_files import read_flat

    if not columns:
        return read_flat(Path(recording))
    with needs("diagnosis", "reading other columns"):
        from deltactl.recording.foreign.mapping import load_mapping
        from deltactl.recording.foreign.reading import read_mapped
    return read_mapped(Path(recording), load_mapping(None, _options(columns)))


def load_robot(robot: AnyPath) -> RobotModel:
    """Read a robot file of any kind. Raises ConfigError or MissingFile."""
    return load_with_effects(find(str(robot), key=ROBOT_KEY))


def simulate(
    job: AnyPath,
    robot: AnyPath | None = None,
    *,
    record: AnyPath | None = None,
    seed: int | None = None,
) -> JobResult:
    """Run a job on a simulated robot, faster than real time.

    robot: another robot file than the job's; record: where the recording goes (a name in
    `recordings` otherwise); seed: of the simulated sensors' noise. Raises ConfigError, MissingFile
    or MotionError before anything moves; how the job ended is in the result.
    """
    from deltactl.firmware_py.controller.build import build_controller
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.program.includes import job_of
    from deltactl.foundation.clock import sleep_s

    path = find(str(job), key=JOB_KEY)
    files = FileAccess()
    named = find(job_of(path, files).robot, beside=path, key=ROBOT_KEY) if robot is None else None
    robot_file = named or find(str(robot), key=ROBOT_KEY)
    controller = build_controller(
        robot_file,
        simulated=True,
        realtime=False,
        recordings=Path("recordings"),
        seed=seed,
        files=files,
    )
    try:
        controller.power_on()
        controller.home(ANY_DEG)
        number = controller.submit(path, None if record is None else Path(record))
        while (result := controller.result(number)) is None:
            sleep_s(controller.clock, POLL_S)
        return result
    finally:
        controller.close()


def run(job: AnyPath, *, record: AnyPath | None = None, socket: AnyPath | None = None) -> JobResult:
    """Run a job on the robot of the daemon and wait for its end.

    An interruption (Ctrl-C, the stop button of a notebook) cancels the job: the robot decelerates.
    Raises ServiceError when no daemon answers, and whatever the daemon refuses the job with.
    """
    from deltactl.firmware_py.daemon.client import Client

    path = find(str(job), key=JOB_KEY)
    with Client(None if socket is None else Path(socket)) as client:
        number = client.submit(path.resolve(), None if record is None else Path(record))
        while (result := client.result(number)) is None:
            try:
                time.sleep(POLL_S)
            except KeyboardInterrupt:
                client.cancel(number)
        return result


def _options(columns: AnyMapping[str, str]) -> list[str]:
    """As `--set` takes them. Raises ConfigError for what is no text."""
    for name, source in columns.items():
        if not isinstance(source, str):
            raise ConfigError(f"columns: {name}: {source!r} is no text such as 'angle[deg]'")
    return [f"{name}={source}" for name, source in columns.items()]
