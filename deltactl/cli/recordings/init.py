"""`deltactl init`: describe a machine, from questions, options and a recording."""

from __future__ import annotations

import shlex
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deltactl.cli.file_arguments import written_if_right
from deltactl.cli.output import console, say, tell, warn
from deltactl.firmware_py.describing.questions import QUESTIONS, WIRING, gather, remarks
from deltactl.firmware_py.describing.robot_text import robot_text
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs
from deltactl.foundation.one_screen import wrapped

if TYPE_CHECKING:
    from deltactl.firmware_py.describing.question import Question
    from deltactl.firmware_py.describing.questions import Answers
    from deltactl.recording.tables.flat import FlatRecording

WIRED = "For hardware (a delta; all are asked for with --wiring)"
SAID = {
    question.key: question.text
    for question in (*(q for qs in QUESTIONS.values() for q in qs), *WIRING)
}


def _asked(key: str) -> Any:
    """The option that answers a question without asking."""
    wired = any(question.key == key for question in WIRING)
    kinds = [
        kind for kind, asked in QUESTIONS.items() if any(question.key == key for question in asked)
    ]
    only = next(
        (question.only for question in QUESTIONS["servo_axis"] if question.key == key), None
    )
    of = f"For {' and '.join(kinds)}" if only is None else f"For {only[2]}"
    panel = WIRED if wired else "Every kind" if len(kinds) > 2 else of
    return typer.Option(help=SAID[key], rich_help_panel=panel)


class Kind(StrEnum):
    """What a machine may be."""

    DELTA = "delta"
    STEPPER_AXIS = "stepper_axis"
    SERVO_AXIS = "servo_axis"
    RANGE_SENSOR = "range_sensor"


def init(
    file: Annotated[Path, typer.Argument(help="Robot file to write (.yaml).")],
    kind: Annotated[
        Kind,
        typer.Option(
            help="What the machine is. servo_axis: any axis that is told positions, a stepper's"
            " slide too; stepper_axis: one whose steps are recorded."
        ),
    ] = Kind.DELTA,
    wiring: Annotated[
        bool, typer.Option("--wiring", help="Also pins, limits and homing, for hardware.")
    ] = False,
    measure: Annotated[
        Path | None, typer.Option(help="A recording: measure what it tells of the machine.")
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option("--set", help="How that recording is read, as for deltactl diagnose."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
    name: Annotated[str | None, _asked("name")] = None,
    base_radius_mm: Annotated[str | None, _asked("base_radius_mm")] = None,
    platform_radius_mm: Annotated[str | None, _asked("platform_radius_mm")] = None,
    upper_arm_mm: Annotated[str | None, _asked("upper_arm_mm")] = None,
    forearm_mm: Annotated[str | None, _asked("forearm_mm")] = None,
    microsteps_per_rev: Annotated[str | None, _asked("microsteps_per_rev")] = None,
    gear_ratio: Annotated[str | None, _asked("gear_ratio")] = None,
    sensors: Annotated[str | None, _asked("sensors")] = None,
    motion: Annotated[str | None, _asked("motion")] = None,
    recorded: Annotated[str | None, _asked("recorded")] = None,
    inertia: Annotated[str | None, _asked("inertia")] = None,
    effort_gain: Annotated[str | None, _asked("effort_gain")] = None,
    hanging_nm: Annotated[str | None, _asked("hanging_nm")] = None,
    hanging_deg: Annotated[str | None, _asked("hanging_deg")] = None,
    slope_n: Annotated[str | None, _asked("slope_n")] = None,
    zero: Annotated[str | None, _asked("zero")] = None,
    step_pins: Annotated[str | None, _asked("step_pins")] = None,
    direction_pins: Annotated[str | None, _asked("direction_pins")] = None,
    enable_pin: Annotated[str | None, _asked("enable_pin")] = None,
    alarm_pins: Annotated[str | None, _asked("alarm_pins")] = None,
    estop_pin: Annotated[str | None, _asked("estop_pin")] = None,
    xshut_pins: Annotated[str | None, _asked("xshut_pins")] = None,
    arm_deg: Annotated[str | None, _asked("arm_deg")] = None,
    step_rate_hz: Annotated[str | None, _asked("step_rate_hz")] = None,
    joint_speed_radps: Annotated[str | None, _asked("joint_speed_radps")] = None,
    joint_acceleration_radps2: Annotated[str | None, _asked("joint_acceleration_radps2")] = None,
    approach_speed_radps: Annotated[str | None, _asked("approach_speed_radps")] = None,
    home_deg: Annotated[str | None, _asked("home_deg")] = None,
) -> None:
    """Write a robot file, and for a delta a first job. Asks for what no option gives.

    ```
    deltactl init my-robot.yaml
    deltactl init axis.yaml --kind servo_axis --motion linear --name slide
    deltactl init table.yaml --kind stepper_axis --measure run.csv
    ```
    """
    options = dict(locals())
    given = {key: options[key] for key in SAID if options[key] is not None}
    wiring = wiring or (kind is Kind.DELTA and any(question.key in given for question in WIRING))
    questions = QUESTIONS[kind.value] + (WIRING if wiring else ())
    keys = {question.key for question in questions}
    if extra := [key for key in given if key not in keys]:
        names = ", ".join("--" + key.replace("_", "-") for key in extra)
        raise ConfigError(f"{names}: a {kind.value} has no such thing; leave it out")
    known = given
    if file.exists() and not force:
        raise ConfigError(f"{file}: exists already; name another file, or add --force")
    if measure is not None:
        found, columns = _measured(kind.value, measure, columns or [], known)
        known = found | known
    if "name" in keys and "name" not in known:
        known["name"] = file.stem
    ask = _ask if sys.stdin.isatty() else None
    answers = gather(questions, known, ask)
    for line in remarks(questions, known if ask is None else answers, answers):
        tell(line)
    for line in _write(file, kind.value, robot_text(kind.value, answers, wiring), force):
        (say if line.startswith(COPIED) else tell)(line)
    if kind is not Kind.DELTA:
        say(f"next: {_diagnosing(file, measure, columns or [])}")


ANSWER = 12
"""Columns that are left for what is typed behind a question."""


def _ask(question: Question) -> str:
    """Asked again until the answer is valid: refused later, it would cost all the others."""
    while True:
        room = console.width - len(f" [{question.default}]: ") - ANSWER
        text = "\n".join(wrapped(question.text, room))
        answer = str(typer.prompt(text, default=question.default))
        if not (wrong := question.wrong(answer)):
            return answer
        say(wrong)


def _measured(
    kind: str, path: Path, columns: list[str], known: Answers
) -> tuple[Answers, list[str]]:
    """What the recording tells, and the options that read it."""
    from deltactl.firmware_py.describing.robot_text import measured

    recording, columns = _read(path, columns)
    answers, said = measured(kind, recording, known)
    for line in said:
        say(line)
    return answers, columns


def _read(path: Path, columns: list[str]) -> tuple[FlatRecording, list[str]]:
    """As it is said, and where that does not do as --inspect would read it, which is then said."""
    from deltactl.cli.recordings.diagnosing import read_with
    from deltactl.cli.recordings.tables import mapping_of
    from deltactl.foundation.errors import RecordingError

    try:
        return read_with(columns)(path), columns
    except RecordingError as error:
        wrong = error
    with needs("diagnosis", "init --measure"):
        from deltactl.recording.foreign.inspection import inspect
        from deltactl.recording.foreign.reading import read_mapped
    try:
        seen = inspect(path, mapping_of(columns))
        recording = read_mapped(path, seen.mapping, tell=warn)
    except RecordingError:
        raise wrong from None
    options = [word for word in seen.options if word != "--set"]
    say(f"{path.name} is read with: {shlex.join(options)}")
    for warning in seen.warnings:
        warn(f"look here: {warning}")
    return recording, options


def _write(file: Path, kind: str, text: str, force: bool) -> list[str]:
    """Write the file and check it; what is to be said of it, and of a delta what comes next."""
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.models.robot_files import load_with_effects

    job: list[str] = []
    with written_if_right(file, text):
        load_robot(file) if kind == "delta" else load_with_effects(file)
        if kind == "delta":
            job = _first_job(file, force)
    return [f"robot file: {file}", *job]


def _diagnosing(file: Path, recording: Path | None, columns: list[str]) -> str:
    """The command that diagnoses the recording a lone machine was measured by, or any."""
    if recording is not None:
        sets = [word for option in columns for word in ("--set", option)]
        return shlex.join(["deltactl", "diagnose", str(recording), "--robot", str(file), *sets])
    options = " (with the --set options that --inspect prints)"
    return f"deltactl diagnose RECORDING --robot {file}{options}"


COPIED = ("next: ", "then: ", "robot file: ")
"""What such a line begins with is copied from the window, so no line break may get into it."""
BY_OTHERS = (
    "for a diagnosis: this robot has no sensors, so record the arm angles (columns theta_1..3) or"
    " the platform's position (pos_x..z) yourself, beside the steps (steps_1..3)"
)


def _first_job(file: Path, force: bool) -> list[str]:
    """Write it; what is to be said of it. Raises ConfigError for arms that cannot be built."""
    from deltactl.firmware_py.controller.sensing.determined import unseen_by_none_deg
    from deltactl.firmware_py.describing.first_job import cannot_be_built, write_first_job
    from deltactl.firmware_py.robot_file import load_robot

    job = file.with_name(f"{file.stem}-circle.yaml")
    if job.exists() and not force:
        return [f"job: {job} exists already and is kept", f"next: deltactl check {job}"]
    robot = load_robot(file)
    what = write_first_job(robot, file, job)
    if what is None:
        if wrong := cannot_be_built(robot):
            raise ConfigError(f"{wrong} Nothing was written")
        warn(
            "no circle fits, so no job was written: look whether the limits and the home angles in"
            f" {file} leave the arms room to move"
        )
        return []
    lines = [
        f"job: {job}, {what}",
        f"next: deltactl check {job}",
        f"then: deltactl run {job}",
    ]
    if robot.sensors is not None:
        return [*lines, f"then: deltactl diagnose RECORDING --robot {file}"]
    return [*lines, BY_OTHERS, _homing(unseen_by_none_deg(robot))]


def _homing(off_deg: int) -> str:
    """What is to be done on the real robot where no sensor looks."""
    return (
        "on the real robot no sensor checks that the arms are at their stops: look yourself, then"
        f" type: deltactl home --accept-unseen {off_deg} ({off_deg} degrees is how far an arm of"
        " this robot could be off without anything noticing; the number says that you have looked)"
    )
