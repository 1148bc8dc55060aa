"""`deltactl inspect`: what a table seems to be, and the command that reads it."""

from __future__ import annotations

import itertools
import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from deltactl.cli.file_arguments import refuse_missing
from deltactl.cli.output import broken, console, print_json, say, waiting, warn
from deltactl.cli.recordings.columns_shown import print_columns
from deltactl.cli.recordings.tables import mapping_of
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from deltactl.recording.foreign.found import Inspection

Seen = TypeVar("Seen")
OF_THE_RUN = "ROBOT is the robot file that it was made with"
ANEW = " in a new file ('deltactl init' with --force would write over the old one)"
OTHERWISE = (
    "if this is another machine, write it anew: 'deltactl init' with --force or another name"
)
FORCED = ["--recorded", "effort", "--inertia", "INERTIA"]
FORCED_SAYS = "  INERTIA: what moves, {mass}, as well as it is known"
MEASURED_SAYS = "  what moves is measured; if you know it ({mass}), add --inertia"
HUNG_SAYS = "  what moves and what hangs on it is measured; if you know it, add --inertia ({mass})"
GAIN_SAYS = "  GAIN: {force} for one unit of the effort, or unknown"
GAIN_UNSAID = "  if you know --effort-gain ({force} for one unit of the effort), add it"
GAIN_KNOWN = "  --effort-gain 1: it is in {force}; if that is at a motor, put its gear's ratio"
WEIGHED = "; where a weight pulls at it, also {weight}"
OF_ANGLES = ["--gear-ratio", "1", "--microsteps-per-rev", "1600", "--sensors", "none"]
"""For a delta whose angles were recorded, not its steps, and no distances."""
STEPPED = ["--microsteps-per-rev", "STEPS", "--gear-ratio", "GEAR"]
STEPPED_SAYS = (
    "  STEPS: step pulses for one turn of the motor, as set at the drive: 1600, or 200x8",
    "  GEAR: turns of the motor for one turn of the axis: 5 for a gear of 5:1, 1 without a gear",
)
OF_MOTION = {
    "rotary": ("kg m2", "N m", "--hanging-nm or --constant-nm"),
    "linear": ("kg", "N", "--slope-n"),
    "MOTION": (
        "kg m2 or kg",
        "N m or N",
        "--hanging-nm, --constant-nm (rotary) or --slope-n (linear)",
    ),
}
"""By the motion of an axis: units of what moves and of what moves it, and the options that say what
a weight does."""


def inspect_recordings(
    recordings: list[Path],
    robot: str | None,
    save: Path | None,
    as_json: bool,
    columns: list[str],
) -> None:
    """Print what each table seems to be. Raises RecordingError or ConfigError.

    columns: what is known already, as --columns and --set say it.
    """
    refuse_missing(recordings)
    with waiting("loading", as_json) as show:
        with needs("diagnosis", "inspect"):
            from deltactl.cli.recordings.fitting import described, looked_at, of_its_own
        known, machine = mapping_of(columns), described(robot)
        show("reading")

        def looked(path: Path) -> tuple[Inspection, str, str | None]:
            if robot is None:
                return of_its_own(path, known, recordings)
            return *looked_at(path, known, machine), robot

        found = _readable(recordings, looked)
    seen = [(_measured(table), why_not, file) for table, why_not, file in found]
    if as_json:
        print_json([table.to_json() for table, _, _ in seen])
    else:
        together = _alike(seen)
        for number, (table, why_not, file) in enumerate(seen, 1):
            paths = recordings if together else [table.path]
            awaited = bool(together) and number < len(seen)
            new = machine is None if robot else file is None
            _show(table, why_not, _Next(paths, file, new, save, awaited, unsaid=robot is None))
    if save is not None:
        write_whole(save, seen[0][0].mapping_text(typed=True))
        if not as_json:
            say(f"mapping: {save}")


@dataclass(frozen=True, slots=True)
class _Next:
    """What the commands below a table are made of."""

    paths: Sequence[Path]
    """The recordings that one command diagnoses."""
    robot: str | None
    new: bool
    """Whether a robot file is still to be written."""
    save: Path | None
    awaited: bool
    """Whether they come below a later table."""
    unsaid: bool = False
    """Whether the robot file was found by its name, which is the table's."""


def _alike(seen: Sequence[tuple[Inspection, str, str | None]]) -> bool:
    """Whether several tables are read alike, so that one command diagnoses them together."""
    ways = {
        (one.kind, one.motion, one.zero, tuple(one.options), why, file) for one, why, file in seen
    }
    return len(ways) == 1 < len(seen) and not seen[0][0].needs_inertia


def _measured(seen: Inspection) -> Inspection:
    """With a word of a table that is too short for a diagnosis."""
    from deltactl.diagnosis.observations.options import OBSERVATIONS
    from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, FORCED_AXIS, RANGE_SENSOR

    fewest = {
        None: 0,
        "servo_axis": COMMANDED_AXIS.fewest_followed_rows,
        "range_sensor": RANGE_SENSOR.fewest_ranged_rows,
    }.get(seen.kind, OBSERVATIONS.fewest_samples)
    fewest = FORCED_AXIS.fewest_forced_rows if seen.needs_inertia else fewest
    rows = len(next(iter(seen.table.values())))
    if rows >= fewest:
        return seen
    short = f"{rows} rows are too few: a diagnosis needs {fewest} at least"
    return replace(seen, warnings=[*seen.warnings, short])


def _readable(paths: list[Path], inspect: Callable[[Path], Seen]) -> list[Seen]:
    """What is seen in those that can be read; one that cannot is named, and the others shown."""
    seen, damaged = [], []
    for path in paths:
        try:
            seen.append(inspect(path))
        except RecordingError as error:
            damaged.append(error)
    if not seen:
        raise damaged[0]
    for why in damaged:
        warn(f"{why}; the others follow")
    return seen


def _show(seen: Inspection, why_not: str, following: _Next) -> None:
    """Print one table on one screen. why_not: why it is none of the robot file's machine."""
    if why_not:
        says = f"not of {following.robot}: {why_not}; the commands below describe its own machine"
        says += ANEW * following.unsaid
        seen = replace(seen, warnings=[says, *seen.warnings])
        following = replace(following, robot=None, new=True)
    read = seen
    if following.new and following.save is None and _has_unused_effort(seen):
        read = seen.without_effort
    known = seen.kind is not None and not following.awaited
    below = seen.asked.units if known and seen.asked else None
    look = [one for one in read.warnings if below is None or not _chooses(one, below)]
    print_columns(seen, look, _commands(seen, read, following) if known else [])


def _chooses(warning: str, units: str) -> bool:
    """Whether a warning asks for one of these units, which lines below the commands do."""
    from deltactl.recording.foreign.notes import Hint

    return isinstance(warning, Hint) and (warning.kind, warning.choice) == ("unit", units)


def _commands(seen: Inspection, read: Inspection, following: _Next) -> list[str]:
    """Lines with what is to be typed next. read: the table as it is read by that."""
    from deltactl.recording.foreign.found import diagnosing
    from deltactl.recording.foreign.mapping import joints_together

    lines: list[str] = []
    robot, new, save = following.robot, following.new, following.save
    if following.unsaid and robot and not new:
        lines += broken(f"{'described already:':23}{robot}; {OTHERWISE}")
    if seen.own_run:
        lines += broken(f"this is a recording of deltactl and is read as it is; {OF_THE_RUN}")
        robot, new = robot or "ROBOT", False
    file = robot or _new(seen)
    if new:
        lines += (_describing_arm if seen.kind == "chain" else _describing)(seen, file)
    typed = [part for one in joints_together(read.options[1::2]) for part in ("--set", one)]
    options = ["--columns", str(save)] if save is not None else typed
    if read is not seen:
        lines += _for_the_effort(seen)
    label = f"{'diagnose it:' if len(following.paths) == 1 else 'diagnose them:':23}"
    lines += _command(label, diagnosing(following.paths, file, options))
    return lines + [part for one in to_be_put(seen, new) for part in broken(one)]


def to_be_put(seen: Inspection, new: bool) -> list[str]:
    """What its owner puts for the words in the options of a table, and for MOTION of a new axis."""
    from deltactl.recording.foreign.units import either

    owed = [f"  {factor.word}: {factor.says}" for factor in seen.factors.values()]
    if (asked := seen.asked) is None:
        return owed
    if not (new and asked.motion):
        return [f"  UNIT, of {asked.named}: {asked.units}", *owed]
    choices = (("turns: ", "rotary", asked.rotary), ("slides:", "linear", asked.linear))
    return [
        f"  if it {does} MOTION is {what}, UNIT is {either(units)}" for does, what, units in choices
    ] + owed


def _describing(seen: Inspection, file: str) -> list[str]:
    """Lines with the command that writes a robot file."""
    from deltactl.recording.foreign.found import init_words

    assert seen.kind is not None
    moves = _motion(seen)
    motion = ["--motion", moves] if seen.kind == "servo_axis" else []
    zero = ["--zero", seen.zero] if seen.zero and seen.kind != "delta" else []
    there = {guess.name for guess in seen.guesses.values()}
    forced, says = _forced(seen) if seen.needs_inertia else ([], ())
    if seen.kind == "servo_axis" and "command" in there:
        forced = ["--recorded", "command"]
    if seen.kind == "stepper_axis":
        forced, says = STEPPED, STEPPED_SAYS
    if seen.kind == "delta" and not {"steps_1", "range_x"} & there:
        forced = OF_ANGLES
    asks_nothing = ["--yes"] if seen.kind == "servo_axis" else []
    init = ["deltactl", *init_words(seen.kind, file), *motion, *forced, *zero, *asks_nothing]
    lines = _command("describe the machine:  ", init)
    mass, force, weight = OF_MOTION[moves]
    said = (one.format(weight=weight, mass=mass, force=force) for one in says)
    return lines + [part for one in said for part in broken(one)]


def _motion(seen: Inspection) -> str:
    """The motion of an axis, as it is typed."""
    return "MOTION" if seen.asked and seen.asked.motion else seen.motion or "rotary"


def _for_the_effort(seen: Inspection) -> list[str]:
    """What is to be added to the commands for an effort that they leave out."""
    from deltactl.recording.foreign.notes import Hint

    mass, force, _ = OF_MOTION[_motion(seen)]
    says = (
        f"  to use the effort too, add --inertia INERTIA ({mass}) --effort-gain GAIN ({force} for 1"
        " of it, or unknown)"
    )
    if option := next((one for one in seen.options if one.startswith("effort=")), ""):
        says += f", and below --set {shlex.quote(option)}"
    outside = any(isinstance(one, Hint) and one.choice == "load" for one in seen.warnings)
    if outside and option:
        load = shlex.quote(option.replace("effort=", "load=", 1))
        says += f" (of a weight or a spring only --set {load})"
    return broken(says)


def _has_unused_effort(seen: Inspection) -> bool:
    """Whether an effort is beside a command, which needs a robot file with an inertia."""
    there = {guess.name for guess in seen.guesses.values()}
    return seen.kind == "servo_axis" and not seen.needs_inertia and "effort" in there


def _forced(seen: Inspection) -> tuple[list[str], Sequence[str]]:
    """What describes an axis of which an effort was recorded, and what is said of it.

    Where the effort goes with the acceleration, the recording itself says what moves.
    """
    from deltactl.firmware_py.describing.measured import moved_by_effort
    from deltactl.recording.foreign.names import by_name
    from deltactl.recording.foreign.reading import read_mapped

    unit, slides = by_name(seen.guesses)["effort"].unit or "", _motion(seen) == "linear"
    known = unit.endswith({"rotary": "m", "linear": "N"}.get(_motion(seen), "?"))
    try:
        one = moved_by_effort(read_mapped(seen.path, seen.mapping), not slides)
    except RecordingError:
        one = None
    words, says, weighed = FORCED, FORCED_SAYS, WEIGHED
    if one is not None:
        words = ["--measure", str(seen.path), *seen.options]
        says, weighed = (MEASURED_SAYS, WEIGHED) if slides else (HUNG_SAYS, "")
    if known:
        return [*words, "--effort-gain", "1"], (says, GAIN_KNOWN + weighed)
    if one is None:
        return [*words, "--effort-gain", "GAIN"], (says, GAIN_SAYS + weighed)
    return words, (says, GAIN_UNSAID + weighed)


def _command(label: str, words: list[str]) -> list[str]:
    """A command to be copied; in a window too narrow for it, over lines that the shell joins."""
    whole = f"{label}{shlex.join(words)}"
    if not console.is_terminal or len(whole) <= console.width:
        return [whole]
    lines, line = [label.rstrip()], ""
    for part in _options(words):
        if line and len(line) + len(part) + 3 > console.width:
            lines.append(f"{line} \\")
            line = "   "
        line = f"{line} {part}" if line else part
    return [*lines, line]


def _options(words: list[str]) -> Iterator[str]:
    """The words of a command, each option with its value."""
    part: list[str] = []
    for word in words:
        if word.startswith("--") and part:
            yield shlex.join(part)
            part = []
        part.append(word)
    yield shlex.join(part)


def _new(seen: Inspection) -> str:
    """A robot file name that is still free: a second machine gets its own file."""
    from deltactl.recording.foreign.found import robot_named_after

    own = robot_named_after(seen.path)
    names = itertools.chain([f"{own}.yaml"], (f"{own}-{n}.yaml" for n in itertools.count(2)))
    return next(name for name in names if not Path(name).exists())


OF_A_MODEL = (
    "  MODEL.urdf: its URDF or MJCF (.xml); if that has joints beside the {} of the table, add"
    " --joints a,b,c"
)
OF_JOINTS = (
    "  MODEL.urdf: its URDF or MJCF (.xml); joints that it has not (a gripper) are left out of"
    " --joints and of the braces below; where it calls some otherwise, --joints has its names"
)
OF_A_GAIN = "  GAIN: N m at the joint for 1 of {}, or 11.9,9.8,...; or unknown"


def _describing_arm(seen: Inspection, file: str) -> list[str]:
    """The same of an arm with its URDF."""
    from deltactl.recording.foreign.arms import (
        angle_of_one,
        effort_column,
        joint_names,
        unit_of_angles,
    )
    from deltactl.recording.foreign.found import init_words
    from deltactl.recording.foreign.names import of_role, without_unit

    names, current = joint_names(seen), effort_column(seen)
    joints = ["--joints", ",".join(names)] if names else []
    gain = ["--effort-gain", "GAIN"] if current else []
    init = ["deltactl", *init_words("chain", file), *joints, *gain]
    says = [OF_JOINTS if names else OF_A_MODEL.format(len(of_role(seen.guesses, "theta")))]
    says += [OF_A_GAIN.format(current)] if current else []
    angle = without_unit(angle_of_one(seen))
    alone = ["deltactl", "inspect", str(seen.path), "--set", f"position={angle}"]
    if (unit := unit_of_angles(seen)) is not None:
        alone += ["--set", f"unit={unit}"]
    return [
        *_command("describe the machine:  ", init),
        *(part for one in says for part in broken(one)),
        *_command("  without a model, one joint: ", alone),
    ]
