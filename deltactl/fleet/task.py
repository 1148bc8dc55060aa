"""What is asked of one recording: which robot it is of, its answer, and the book of answers."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from deltactl.diagnosis.admission.which_robot import no_robot_fits
from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.foundation.plain_file import said_of_output
from deltactl.foundation.strict_yaml import Document

_DATE = re.compile(r"(\d{4})-(\d\d)-(\d\d)(?:[T_](\d\d)-?(\d\d)-?(\d\d))?")


@dataclass(frozen=True)
class Robots:
    """Robot files of a folder: by the name of the file, and by the name inside."""

    by_stem: dict[str, Path]
    by_name: dict[str, Path]

    @classmethod
    def in_folder(cls, folder: Path) -> Robots:
        """Read the names. Raises ConfigError when there are none, or one name occurs twice."""
        stems: dict[str, Path] = {}
        names: dict[str, Path] = {}
        for path in sorted(folder.glob("*.yaml")):
            try:
                data = Document.read(path).data
            except ConfigError:  # its recordings will say so, each in its row
                stems[path.stem] = path
                continue
            if "kind" not in data:
                continue  # a job
            stems[path.stem] = path
            name = str(data.get("name", path.stem))
            if name in names:
                raise ConfigError(f"{path}: {names[name].name} is called '{name}' too; rename one")
            names[name] = path
        if not stems:
            raise ConfigError(f"{folder}: no robot file (.yaml with 'kind') lies there")
        return cls(stems, names)

    def of(self, recording: Path) -> tuple[str, Path]:
        """Name and file of a recording's robot: as the recording says, or by its folder or name.

        Raises RecordingError.
        """
        if recording.suffix == ".mcap":
            from deltactl.recording.reading.reader import read_run

            said = read_run(recording).configuration.robot_name
            if said in self.by_name:
                return said, self.by_name[said]
        for part in (recording.name, *reversed(recording.parent.parts)):
            fitting = [stem for stem in self.by_stem if _begins(part, stem)]
            if fitting:
                stem = max(fitting, key=len)
                return stem, self.by_stem[stem]
        raise no_robot_fits(recording)


def recorded_at(recording: Path) -> datetime:
    """When a run was: as it says, by a date in its name, or when the file was written."""
    if recording.suffix == ".mcap":
        from deltactl.recording.reading.reader import read_run

        epoch_ns = read_run(recording).configuration.start_epoch_ns
        if epoch_ns > 0:
            return datetime.fromtimestamp(epoch_ns / 1e9, UTC)
    if (found := _DATE.search(recording.name)) is not None:
        parts = [int(part) for part in found.groups() if part is not None]
        try:
            return datetime(*parts, tzinfo=UTC)  # type: ignore[arg-type, misc]
        except ValueError:
            pass  # digits that are no date
    return datetime.fromtimestamp(recording.stat().st_mtime, UTC)


def _begins(part: str, stem: str) -> bool:
    """Whether a name is the stem, or begins with it and something that is not part of a word."""
    return part.startswith(stem) and not part[len(stem) : len(stem) + 1].isalnum()


Row = dict[str, Any]
NAME = "answers.jsonl"


def stamp_of(path: Path) -> str:
    """Changes when the file does."""
    its = path.stat()
    return f"{its.st_size}-{its.st_mtime_ns}"


class Book:
    """Answers in the order they came. A line that was cut off is forgotten, and done again."""

    def __init__(self, folder: Path):
        self._path = folder / NAME
        with said_of_output(folder):
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("a", encoding="utf-8")
        if self._path.stat().st_size and not self._path.read_bytes().endswith(b"\n"):
            self._file.write("\n")

    def add(self, row: Row) -> None:
        """Write an answer down, at once."""
        self._file.write(json.dumps(row, allow_nan=True) + "\n")
        self._file.flush()

    def rows(self) -> Iterator[Row]:
        """All answers; of a recording that was answered again, every one."""
        with self._path.open(encoding="utf-8") as lines:
            for line in lines:
                try:
                    row = json.loads(line)
                except ValueError:
                    continue
                if isinstance(row, dict) and "recording" in row:
                    yield row

    def done(self) -> dict[str, str]:
        """Recording -> stamp of the file that was answered."""
        return {row["recording"]: row["stamp"] for row in self.rows()}

    def close(self) -> None:
        """Give the file back."""
        self._file.close()


def _quantity(effect: str, parameter: str) -> str:
    """The effect that a row counts for. Play and friction both show as a width at reversals; one
    recording names the one, the next the other. Over many they are one quantity; the row keeps what
    was said beside it.
    """
    from deltactl.models.effects import Trait, has, with_trait

    same = parameter == "width" and has(effect, Trait.HYSTERESIS)
    return with_trait(Trait.HYSTERESIS)[0] if same else effect


def diagnose_one(recording: str, robot: str) -> Row:
    """Answer of one recording: {"verdict", "findings": [...], ...} or {"error": one line}."""
    from deltactl.diagnosis.api import diagnose
    from deltactl.diagnosis.report.headline import headline

    started_s = time.monotonic()
    try:
        answer = diagnose([Path(recording)], Path(robot))
    except (DeltactlError, OSError) as error:
        return {"error": " ".join(str(error).split())}
    except Exception as error:
        # A fleet does not stop at one file, whatever is wrong with it.
        return {"error": f"{recording}: {type(error).__name__}: {error}"}
    fit = answer.fit
    return {
        "verdict": answer.verdict,
        "says": headline(answer, brief=True),
        "false_alarm_p": answer.false_alarm_p,
        "rms_before": fit.rms_before_m,
        "rms_after": fit.rms_after_m,
        "noise_floor": fit.noise_floor_m,
        "findings": [row for finding in answer.findings for row in _sizes(finding)],
        "detectable": {
            f"{least.effect} {least.component}": least.value for least in answer.smallest_detectable
        },
        "seconds": time.monotonic() - started_s,
    }


def _sizes(finding: Any) -> list[Row]:
    """A row for each size of a finding (a vector gives several)."""
    rows = []
    for name, parameter in finding.parameters.items():
        for number, (value, low, high) in enumerate(parameter.components):
            whole = len(parameter.components) == 1
            rows.append(
                {
                    "effect": _quantity(finding.effect, name),
                    "named": finding.effect,
                    "component": finding.component,
                    "parameter": name if whole else f"{name}[{number}]",
                    "value": value,
                    "low": low,
                    "high": high,
                    "unit": parameter.unit,
                    "probability": finding.probability,
                    "share": finding.share_of_mismatch,
                    "alternatives": [
                        {
                            "effect": other.effect,
                            "component": other.component,
                            "probability": other.probability,
                        }
                        for other in finding.alternatives
                    ],
                }
            )
    return rows
