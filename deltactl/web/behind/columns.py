"""What the columns of somebody's table are, as chosen on the page: a file beside the table."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from deltactl.web.behind.own_recordings import CHOSEN

AS_IT_IS = "1"
"""The unit of what is in the contract's already, or is none."""
OPTION = re.compile(r"[;:]?(?: [^;:]*:)? (?:type: )?deltactl diagnose --inspect .*$", re.DOTALL)
"""What a message says to type."""

IN_COMMANDS = re.compile(r"put \[?(\w+)\]? in place of .*")


@dataclass(frozen=True, slots=True)
class Chosen:
    """A column of the table, what it is, and in which unit; no name: it is not used."""

    column: str
    name: str
    unit: str


def inspected(path: Path) -> dict[str, Any]:
    """How a table is read, guessed from its headings and values; plain types for the page.

    Raises RecordingError.
    """
    from deltactl.recording.foreign.inspection import inspect
    from deltactl.recording.foreign.units import UNITS_OF
    from deltactl.recording.tables.flat import UNITS

    found = inspect(path)
    mapped = {source.from_: name for name, source in found.mapping.columns.items()}
    columns = []
    for column, values in found.table.items():
        name = mapped.get(column, column if column in UNITS else "")
        unit = found.mapping.columns[name].unit if column in mapped else AS_IT_IS
        first = ", ".join(f"{value:.6g}" for value in values[:3])
        columns.append({"column": column, "name": name, "unit": unit, "first": first})
    units = {name: UNITS_OF.get(re.sub(r"_[123xyz]$", "", name), ()) for name in UNITS}
    return {
        "columns": columns,
        "units_of": {name: [AS_IT_IS, *known] for name, known in units.items()},
        "mapping": found.mapping_text(),
        "warnings": [IN_COMMANDS.sub(r"choose \1", one) for one in found.warnings],
    }


def mapping_text(guessed: str, chosen: Iterable[Chosen]) -> str:
    """The mapping file of a choice. guessed: the one of the inspection, which knows factors too."""
    mapping = yaml.safe_load(guessed)
    before, mapping["columns"] = mapping.get("columns") or {}, {}
    for one in chosen:
        if one.name:
            same = before.get(one.name, {})
            kept = same.get("from") == one.column and same.get("unit", AS_IT_IS) == one.unit
            mapping["columns"][one.name] = same if kept else {"from": one.column, "unit": one.unit}
    return str(yaml.safe_dump(mapping, sort_keys=False, allow_unicode=True))


def reader() -> Callable[[Path], Any]:
    """What reads recordings: those whose columns were chosen by that choice."""
    from deltactl.recording.foreign.mapping import load_mapping
    from deltactl.recording.foreign.reading import read_mapped
    from deltactl.recording.tables.flat_files import read_flat

    def read(path: Path) -> Any:
        chosen = path.with_name(f"{path.name}{CHOSEN}")
        return read_mapped(path, load_mapping(chosen)) if chosen.is_file() else read_flat(path)

    return read
