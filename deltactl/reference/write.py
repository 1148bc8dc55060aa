"""The pages in Markdown."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel

from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.protocol import ARGUMENTS, SLOW, Argument
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.robot_file import SAID_FOR_HARDWARE, RobotFile
from deltactl.foundation.plain_file import write_whole
from deltactl.models.effects import PORT_TEXT, TABLES, VOCABULARY
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects
from deltactl.models.robot import KINDS
from deltactl.recording.foreign.mapping import Mapping
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.format.channels import CHANNELS
from deltactl.recording.tables.flat import UNITS
from deltactl.reference import states_page
from deltactl.reference.examples import example_of
from deltactl.reference.fields import NAMES, Key, Section, sections
from deltactl.reference.schemas import example, schemas
from deltactl.reference.words import ARGUMENT_WORDS, COLUMN_WORDS, REQUEST_WORDS, stem_of

ROOT = Path(__file__).parents[2]
MADE = "<!-- Made by `make reference` from the code; a test fails when it is stale. -->"


def pages() -> dict[str, str]:
    """Text of each page by its name under docs/reference/."""
    return {
        "README.md": _contents(),
        "jobs.md": _jobs(),
        "robots.md": _robots(),
        "effects.md": _effects(),
        "columns.md": _columns(),
        "socket.md": _socket(),
        "states.md": _states(),
    }


def _page(title: str, *parts: str) -> str:
    return "\n\n".join([f"# {title}", MADE, *(part for part in parts if part)]) + "\n"


def _contents() -> str:
    return _page(
        "Reference",
        "- [Job files](jobs.md)\n- [Robot files](robots.md), every kind of machine\n"
        "- [Effects](effects.md): what the diagnosis can name\n- [Columns](columns.md) of tables, "
        "mappings, and the channels of recordings\n- [Requests](socket.md) of the daemon's socket\n"
        "- [States](states.md): what each request does, and what may still move",
        "Editors check and complete these files with the JSON Schemas in `deltactl/schemas/`. In "
        "VS Code with the YAML extension, or any editor with yaml-language-server, a first line "
        "does it:",
        "```yaml\n# yaml-language-server: $schema=../deltactl/schemas/robot.json\n```",
    )


def _jobs() -> str:
    return _page(
        "Job files",
        "What is run: `deltactl check JOB.yaml`, `deltactl run JOB.yaml`. Schema: "
        "`deltactl/schemas/job.json`. An unknown key is refused.",
        *_tables(JobFile),
    )


def _robots() -> str:
    must = ", ".join(f"`{s}.{key}`" for s, keys in SAID_FOR_HARDWARE.items() for key in keys)
    parts = [
        "What a perfect machine would be. `deltactl init` writes one. Schema: "
        "`deltactl/schemas/robot.json`. An unknown key is refused.",
        f"On hardware these must be said, and have no default: {must}. A file without them runs "
        "simulated only.",
    ]
    for kind, model in KINDS.items():
        whole = RobotFile if kind == "delta" else model
        parts += [f"## kind: {kind}", *_examples(kind), *_tables(whole)]
    return _page("Robot files", *parts)


def _examples(kind: str) -> list[str]:
    names = [
        f"`config/{path.name}`"
        for path in sorted((ROOT / "config").glob("*.yaml"))
        if yaml.safe_load(path.read_text(encoding="utf-8")).get("kind") == kind
    ]
    return [f"Examples: {', '.join(names)}."] if names else []


def _tables(model: type[BaseModel]) -> list[str]:
    parts: list[str] = []
    for section in sections(model):
        parts += _table(section)
    return parts


def _table(section: Section) -> list[str]:
    head = f"`{section.place}`" if section.place else "The file"
    choice = f", `{section.choice}`" if section.choice and section.place else ""
    rows = [
        (
            f"`{key.name}`",
            key.type,
            key.unit,
            key.bounds,
            key.default,
            _example(section, key),
            key.says,
        )
        for key in section.keys
    ]
    columns = ("key", "type", "unit", "bounds", "default", "example", "")
    return [f"### {head}{choice}", section.says, table(columns, rows)]


LONGEST_EXAMPLE = 70
"""A section that is longer is shown by its own keys."""


def _example(section: Section, key: Key) -> str:
    """A value as a file has it."""
    shown = f"`{in_one_line(example_of(section.model, key.name))}`"
    return shown if len(shown) <= LONGEST_EXAMPLE else "its keys are below"


def in_one_line(value: Any) -> str:
    """A value in YAML, without a line break."""
    text = yaml.safe_dump(value, default_flow_style=True, width=10_000, sort_keys=False)
    return " ".join(text.removesuffix("...\n").split())


def table(columns: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    lines = [list(columns)]
    lines += [
        ["---"] * len(lines[0]),
        *([cell.replace("|", "\\|") for cell in row] for row in rows),
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _effects() -> str:
    parts = [
        "What the diagnosis can name, what a robot file may state under `effects`, and what a "
        "simulated robot may have under `as_built`. Values are in SI units.",
        "## Deltas",
        _effect_table(VOCABULARY),
        "What has no name may stand there as a table over what it follows: of a joint over the"
        " angle of an arm (1 to 3), of the platform over x, y, z (1 to 3) or the distance from the"
        " z axis (4). Places are evenly spaced, errors linear between them.",
        _effect_table(TABLES),
        "## Axes that follow a command",
        "On a linear axis m, N and kg stand in place of rad, N m and kg m2, and in its robot file"
        " `offset` in place of `angle`, `force` in place of `torque`.",
        _effect_table(command_effects("rotary")),
        "## Axes that are driven by effort",
        _effect_table(effort_effects("rotary")),
        "## Range sensors alone",
        _effect_table(sensor_effects()),
        "An example: `effects: [{effect: gear_backlash, component: motor2, parameters: "
        "{width: 0.004}}]`",
    ]
    return _page("Effects", *parts)


def _effect_table(kinds: dict[str, EffectKind]) -> str:
    rows = [
        (
            f"`{kind.name}`",
            ", ".join(kind.components),
            f"`{parameter.name}`",
            parameter.unit,
            f"{parameter.low:g} to {parameter.high:g}",
            "required" if parameter.default is None else f"{parameter.default:g}",
            in_one_line(example(kind, parameter)),
            PORT_TEXT[kind.port],
        )
        for kind in sorted(kinds.values(), key=lambda kind: kind.name)
        for parameter in kind.parameters
    ]
    return table(
        ("effect", "component", "parameter", "unit", "plausible", "default", "example", "at"), rows
    )


def _columns() -> str:
    units = ", ".join(f"`{unit}`" for unit in IN_SI)
    parts = [
        "## Tables",
        "One row a sample; `t` increases; cells may be empty. Columns of other names are kept.",
        "None has a default: which are needed depends on the machine, and a message says what is "
        "missing and what could stand for it.",
        table(("column", "unit", "example", ""), _column_rows()),
        "## Mappings",
        "`--columns FILE` or `--set NAME=COLUMN[unit]` bring other names and units to these. "
        "`deltactl diagnose --inspect FILE` proposes one. Schema: `deltactl/schemas/mapping.json`. "
        "Where `separator` and `decimal` are not given, they are found by looking at the file. "
        "Units: "
        f"{units}.",
        *_tables(Mapping),
        "## Channels of a recording (MCAP)",
    ]
    for channel in CHANNELS:
        rows = [(f"`{field.name}`", field.kind, field.says) for field in channel.fields]
        parts += [f"### `{channel.topic}`", channel.says, table(("field", "kind", "says"), rows)]
    return _page("Columns and channels", *parts)


def _column_rows() -> list[tuple[str, ...]]:
    return [
        (f"`{name}`", unit, *map(str, COLUMN_WORDS[stem_of(name)])) for name, unit in UNITS.items()
    ]


def _socket() -> str:
    requests = [
        (
            f"`{do}`",
            ", ".join(f"`{name}`" for name in arguments),
            "one after another" if do in SLOW else "at once",
            REQUEST_WORDS[do],
        )
        for do, arguments in ARGUMENTS.items()
    ]
    asked_for = {
        name: argument for arguments in ARGUMENTS.values() for name, argument in arguments.items()
    }
    arguments = [_argument_row(name, argument) for name, argument in asked_for.items()]
    return _page(
        "Requests of the socket",
        "One JSON object a line, each way; [the service](../service.md) says how. Schema: "
        "`deltactl/schemas/request.json`.",
        table(("do", "with", "carried out", ""), requests),
        "Arguments may all be left out, but `run` needs a `job` or a `job_text`, and `result` a "
        "`job_id`.",
        table(("argument", "type", "unit", "bounds", "default", "example", ""), arguments),
        'An example: `{"id": 1, "do": "run", "job": "/var/lib/deltactl/circle.yaml"}`',
    )


def _states() -> str:
    parts = [states_page.INTRODUCTION, "\n".join(f"- {rule}" for rule in states_page.RULES)]
    names = [f"`{state.value}`" for state in State]
    parts += ["## Next states", "Empty: refused.", table(("", *names), states_page.overview())]
    for state in State:
        parts += [
            f"## {state.value}",
            states_page.STATE_WORDS[state],
            table(states_page.COLUMNS, states_page.rows_of(state)),
            states_page.refused_in(state),
        ]
    return _page("States of the robot", *parts)


def _argument_row(name: str, argument: Argument) -> tuple[str, ...]:
    words = ARGUMENT_WORDS[name]
    length = " characters" if argument.type is str else ""
    return (
        f"`{name}`",
        NAMES[argument.type],
        words.unit,
        "" if argument.type is bool else f"{argument.least:g} to {argument.most:g}{length}",
        "none" if words.default is None else str(words.default),
        f"`{json.dumps(words.example)}`",
        words.says,
    )


def made() -> dict[Path, str]:
    """Every file and its text."""
    texts = {ROOT / "docs" / "reference" / name: text for name, text in pages().items()}
    return texts | {ROOT / "deltactl" / "schemas" / name: text for name, text in schemas().items()}


def main() -> None:
    """Write all of them."""
    for path, text in made().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
