"""`deltactl init`: describe a machine, from questions, options and a recording."""

from __future__ import annotations

import shlex
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deltactl.cli.file_arguments import ForceOption, written_if_right
from deltactl.cli.output import console, say, tell, warn
from deltactl.firmware_py.describing.questions import (
    EFFORT_GAIN,
    GEAR,
    INERTIA,
    QUESTIONS,
    WIRING,
    gather,
    remarks,
)
from deltactl.firmware_py.describing.robot_text import robot_text
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs
from deltactl.foundation.one_screen import wrapped

if TYPE_CHECKING:
    from deltactl.firmware_py.describing.question import Question
    from deltactl.firmware_py.describing.questions import Answers
    from deltactl.recording.tables.flat import FlatRecording

SAID = {
    question.key: question.text
    for question in (*(q for qs in QUESTIONS.values() for q in qs), *WIRING)
}
WIRED = "For hardware (all are asked for with --wiring)"
FORCED = "Where an effort is recorded (force, torque or current)"
STEPPED = "With --drive stepper"
ABOUT = """Describe a machine in a robot file. Asks for what no option gives.

```
deltactl init delta my-robot.yaml
deltactl init axis my-axis.yaml
deltactl init sensor my-sensor.yaml
deltactl init chain my-arm.yaml --model arm.urdf
```
"""
FileArgument = Annotated[Path, typer.Argument(help="Robot file to write (.yaml).")]
MeasureOption = Annotated[
    Path | None, typer.Option(help="A recording: measure what it tells of the machine.")
]
YesOption = Annotated[
    bool, typer.Option("--yes", help="Ask nothing: for what no option gives, take the usual.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", help="How that recording is read, as for deltactl diagnose."),
]


def _asked(key: str, panel: str | None = None) -> Any:
    """The option that answers a question without asking."""
    return typer.Option(help=SAID[key], rich_help_panel=panel)


class Drive(StrEnum):
    """What moves an axis, as its recordings show it."""

    SERVO = "servo"
    STEPPER = "stepper"


def delta(
    file: FileArgument,
    base_radius_mm: Annotated[str | None, _asked("base_radius_mm")] = None,
    platform_radius_mm: Annotated[str | None, _asked("platform_radius_mm")] = None,
    upper_arm_mm: Annotated[str | None, _asked("upper_arm_mm")] = None,
    forearm_mm: Annotated[str | None, _asked("forearm_mm")] = None,
    microsteps_per_rev: Annotated[str | None, _asked("microsteps_per_rev")] = None,
    gear_ratio: Annotated[str | None, _asked(GEAR.key)] = None,
    sensors: Annotated[str | None, _asked("sensors")] = None,
    name: Annotated[str | None, _asked("name")] = None,
    wiring: Annotated[
        bool, typer.Option("--wiring", help="Also pins, limits and homing, for hardware.")
    ] = False,
    force: ForceOption = False,
    step_pins: Annotated[str | None, _asked("step_pins", WIRED)] = None,
    direction_pins: Annotated[str | None, _asked("direction_pins", WIRED)] = None,
    enable_pin: Annotated[str | None, _asked("enable_pin", WIRED)] = None,
    alarm_pins: Annotated[str | None, _asked("alarm_pins", WIRED)] = None,
    estop_pin: Annotated[str | None, _asked("estop_pin", WIRED)] = None,
    xshut_pins: Annotated[str | None, _asked("xshut_pins", WIRED)] = None,
    arm_deg: Annotated[str | None, _asked("arm_deg", WIRED)] = None,
    step_rate_hz: Annotated[str | None, _asked("step_rate_hz", WIRED)] = None,
    joint_speed_radps: Annotated[str | None, _asked("joint_speed_radps", WIRED)] = None,
    joint_acceleration_radps2: Annotated[
        str | None, _asked("joint_acceleration_radps2", WIRED)
    ] = None,
    approach_speed_radps: Annotated[str | None, _asked("approach_speed_radps", WIRED)] = None,
    home_deg: Annotated[str | None, _asked("home_deg", WIRED)] = None,
) -> None:
    """Describe a delta robot: a robot file, and a first job, a circle that fits.

    ```
    deltactl init delta my-robot.yaml
    deltactl init delta config/my-delta.yaml --wiring
    ```
    """
    given = _given(locals())
    wiring = wiring or any(question.key in given for question in WIRING)
    _describe("delta", file, given, force, wiring=wiring)


def axis(
    file: FileArgument,
    drive: Annotated[
        Drive,
        typer.Option(
            help="servo: any axis that gets positions, a stepper's slide too; stepper: one whose"
            " steps are recorded."
        ),
    ] = Drive.SERVO,
    motion: Annotated[str | None, _asked("motion")] = None,
    recorded: Annotated[str | None, _asked("recorded")] = None,
    zero: Annotated[str | None, _asked("zero")] = None,
    name: Annotated[str | None, _asked("name")] = None,
    measure: MeasureOption = None,
    columns: SetOption = None,
    yes: YesOption = False,
    force: ForceOption = False,
    inertia: Annotated[str | None, _asked(INERTIA.key, FORCED)] = None,
    effort_gain: Annotated[str | None, _asked(EFFORT_GAIN.key, FORCED)] = None,
    hanging_nm: Annotated[str | None, _asked("hanging_nm", FORCED)] = None,
    hanging_deg: Annotated[str | None, _asked("hanging_deg", FORCED)] = None,
    constant_nm: Annotated[str | None, _asked("constant_nm", FORCED)] = None,
    slope_n: Annotated[str | None, _asked("slope_n", FORCED)] = None,
    microsteps_per_rev: Annotated[str | None, _asked("microsteps_per_rev", STEPPED)] = None,
    gear_ratio: Annotated[str | None, _asked(GEAR.key, STEPPED)] = None,
) -> None:
    """Describe a single axis that turns or slides.

    ```
    deltactl init axis slide.yaml --motion linear --name slide
    deltactl init axis table.yaml --drive stepper --measure run.csv
    ```
    """
    recorded_by = measure, columns or []
    _describe(f"{drive.value}_axis", file, _given(locals()), force, recorded_by, ask=not yes)


def sensor(
    file: FileArgument,
    name: Annotated[str | None, _asked("name")] = None,
    force: ForceOption = False,
) -> None:
    """Describe a distance sensor.

    ```
    deltactl init sensor lidar.yaml --name lidar
    ```
    """
    _describe("range_sensor", file, _given(locals()), force)


def _given(options: dict[str, Any]) -> Answers:
    """The answers among the options of a command, by question."""
    return {key: options[key] for key in SAID if options.get(key) is not None}


def _describe(
    kind: str,
    file: Path,
    given: Answers,
    force: bool,
    recorded: tuple[Path | None, list[str]] = (None, []),
    wiring: bool = False,
    ask: bool = True,
) -> None:
    """Ask what is missing and write the file; `recorded` is a recording and how it is read."""
    measure, columns = recorded
    questions = QUESTIONS[kind] + (WIRING if wiring else ())
    keys = {question.key for question in questions}
    _refuse_all_but(keys, kind, given)
    known = given
    if file.exists() and not force:
        raise ConfigError(f"{file}: exists already; name another file, or add --force")
    if measure is not None:
        found, columns = _measured(kind, measure, columns, known)
        known = found | known
    known = _with_what_follows(keys, file, known)
    asked = _ask if ask and sys.stdin.isatty() else None
    answers = gather(questions, known, asked)
    for line in remarks(questions, known if asked is None else answers, answers):
        tell(line)
    for line in _write(file, kind, robot_text(kind, answers, wiring), force):
        (say if line.startswith(COPIED) else tell)(line)
    if kind != "delta":
        say(f"next: {_diagnosing(file, measure, columns)}")
        if measure is None:
            tell("with the --set options that deltactl inspect RECORDING prints")


def _with_what_follows(keys: set[str], file: Path, known: Answers) -> Answers:
    """What is known, and what that says of other questions. keys: of all questions."""
    more = {"name": file.stem} if "name" in keys and "name" not in known else {}
    moved = "recorded" in keys and {INERTIA.key, EFFORT_GAIN.key} & known.keys()
    if moved and known.get("recorded", "command") == "command":
        more["recorded"] = "both"  # nothing but an effort needs what moves
    return known | more


def _refuse_all_but(keys: set[str], kind: str, given: Answers) -> None:
    if extra := [key for key in given if key not in keys]:
        names = ", ".join("--" + key.replace("_", "-") for key in extra)
        raise ConfigError(f"{names}: a {kind} has no such thing; leave it out")


ANSWER = 12
"""Columns that are left for what is typed behind a question."""


def _ask(question: Question) -> str:
    """Asked again until the answer is valid: refused later, it would cost all the others."""
    while True:
        room = console.width - len(f" [{question.default}]: ") - ANSWER
        text = "\n".join(wrapped(question.text, room))
        usual = question.default or ""
        answer = str(typer.prompt(text, default=usual, show_default=bool(usual)))
        if not (wrong := question.wrong(answer)):
            return answer
        say(wrong)


def _measured(
    kind: str, path: Path, columns: list[str], known: Answers
) -> tuple[Answers, list[str]]:
    """What the recording tells, and the options that read it."""
    from deltactl.firmware_py.describing.measured import measured

    recording, columns = _read(path, columns, known.get("motion"))
    answers, said = measured(kind, recording, known)
    for line in said:
        say(line)
    return answers, columns


def _read(path: Path, columns: list[str], motion: str | None) -> tuple[FlatRecording, list[str]]:
    """As it is said, and where that does not do as `inspect` would read it, which is then said."""
    from deltactl.cli.recordings.diagnosing import read_with
    from deltactl.cli.recordings.inspect import to_be_put
    from deltactl.cli.recordings.tables import mapping_of
    from deltactl.foundation.errors import RecordingError

    try:
        return read_with(columns)(path), columns
    except RecordingError as error:
        wrong = error
    with needs("diagnosis", "init axis --measure"):
        from deltactl.recording.foreign.inspection import inspect
        from deltactl.recording.foreign.reading import read_mapped
    try:
        seen = inspect(path, mapping_of(columns), motion)
        recording = read_mapped(path, seen.mapping, tell=warn)
    except RecordingError:
        raise wrong from None
    if not recording.has("command") and (owed := seen.owed) is not None:
        raise owed  # only the zero of a command is measured without it
    options = [word for word in seen.options if word != "--set"]
    say(f"{path.name} is read with: {shlex.join(options)}")
    for line in (*(f"look here: {one}" for one in seen.warnings), *to_be_put(seen, new=False)):
        warn(line)
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
    """The command that diagnoses the recording a machine was measured by, or any."""
    if recording is not None:
        sets = [word for option in columns for word in ("--set", option)]
        return shlex.join(["deltactl", "diagnose", str(recording), "--robot", str(file), *sets])
    return f"deltactl diagnose RECORDING --robot {file}"


COPIED = ("next: ", "then: ", "robot file: ")
"""What such a line begins with is copied from the window, so no line break may get into it."""
BY_OTHERS = (
    "for a diagnosis: this robot has no sensors; record the arm angles (columns theta_1..3) or the"
    " platform's position (pos_x..z) yourself"
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
    lines = [f"job: {job}, {what}", f"next: deltactl check {job}", f"then: deltactl run {job}"]
    if robot.sensors is not None:
        return [*lines, f"then: deltactl diagnose RECORDING --robot {file}"]
    homing = [] if robot.left_open() else [_homing(unseen_by_none_deg(robot))]
    return [*lines, BY_OTHERS, *homing]


def _homing(off_deg: int) -> str:
    """What is to be done on the real robot where no sensor looks."""
    return (
        "on the real robot no sensor checks that the arms are at their stops: look yourself, then"
        f" type: deltactl home --accept-unseen {off_deg} ({off_deg} degrees is how far an arm of"
        " this robot could be off without anything noticing; the number says that you have looked)"
    )
