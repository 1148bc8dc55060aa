"""The pages in Markdown."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path

import yaml

from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.protocol import ARGUMENTS, SLOW, Argument
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.robot_file import SAID_FOR_HARDWARE, RobotFile
from deltactl.foundation.plain_file import write_whole
from deltactl.models.effects import PORT_TEXT, TABLES, VOCABULARY
from deltactl.models.effects.kind import EffectKind, Parameter
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects
from deltactl.models.robot import KINDS
from deltactl.recording.foreign.mapping import Mapping
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.format.channels import CHANNELS, Field
from deltactl.recording.tables.flat import UNITS
from deltactl.reference import states_page
from deltactl.reference.fields import NAMES
from deltactl.reference.key_tables import KeyTables, table
from deltactl.reference.robot_picture import robot_picture
from deltactl.reference.schemas import schemas
from deltactl.reference.words import ARGUMENT_WORDS, COLUMN_WORDS, REQUEST_WORDS, stem_of

ROOT = Path(__file__).parents[2]
MADE = "<!-- Made by `make reference` from the code; a test fails when it is stale. -->"


def pages() -> dict[str, str]:
    """Text of each page and picture by its name under docs/reference/."""
    return {
        "README.md": _contents(),
        "jobs.md": _jobs(),
        "robots.md": _robots(),
        "effects.md": _effects(),
        "columns.md": _columns(),
        "socket.md": _socket(),
        "states.md": _states(),
        "robot.svg": robot_picture(),
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
        "`deltactl check JOB.yaml` checks a job, `deltactl run JOB.yaml` runs it. Schema: "
        "`deltactl/schemas/job.json`. An unknown key is refused.",
        "## Sections",
        *KeyTables().of(JobFile),
    )


def _robots() -> str:
    must = ", ".join(f"`{s}.{key}`" for s, keys in SAID_FOR_HARDWARE.items() for key in keys)
    parts = [
        "A robot file describes the machine as designed. `deltactl init` writes one. Schema: "
        "`deltactl/schemas/robot.json`. An unknown key is refused.",
        f"On hardware these keys are required: {must}. A file without them runs only simulated.",
    ]
    tables = KeyTables()
    for kind, model in KINDS.items():
        whole = RobotFile if kind == "delta" else model
        parts += [f"## kind: {kind}", *_examples(kind), *tables.of(whole)]
    return _page("Robot files", *parts)


def _examples(kind: str) -> list[str]:
    names = [
        f"`config/{path.name}`"
        for path in sorted((ROOT / "config").glob("*.yaml"))
        if yaml.safe_load(path.read_text(encoding="utf-8")).get("kind") == kind
    ]
    return [f"Examples: {', '.join(names)}."] if names else []


def _effects() -> str:
    parts = [
        "What the diagnosis can name, what a robot file may state under `effects`, and what a "
        "simulated robot may have under `as_built`. Values are in SI units.",
        "## Deltas",
        _effect_table(VOCABULARY),
        "An error without a name is a table. `joint_table` follows the angle of arm 1, 2 or 3; "
        "`platform_table` and `sensor_table` follow x, y, z of the platform (1 to 3) or its "
        "distance from the z axis (4). Places are evenly spaced, and errors are interpolated "
        "linearly.",
        _effect_table(TABLES),
        "## Axes that follow a command",
        "The component of a single axis or sensor is `axis`. A linear axis uses m, N and kg for "
        "rad, N m and kg m2, and its robot file uses `offset` for `angle` and `force` for "
        "`torque`.",
        _parameter_table(command_effects("rotary")),
        "## Axes that are driven by effort",
        _parameter_table(effort_effects("rotary")),
        "## Range sensors alone",
        _parameter_table(sensor_effects()),
        "An example: `effects: [{effect: gear_backlash, component: motor2, parameters: "
        "{width: 0.004}}]`",
    ]
    return _page("Effects", *parts)


def _effect_table(kinds: dict[str, EffectKind]) -> str:
    rows = [
        (f"`{kind.name}`", _numbered(kind.components), _parameters(kind), PORT_TEXT[kind.port])
        for kind in _by_name(kinds)
    ]
    return table(("effect", "component", "parameters", "acts at"), rows)


def _parameter_table(kinds: dict[str, EffectKind]) -> str:
    """Effects of a machine with one component."""
    rows = [(f"`{kind.name}`", _parameters(kind)) for kind in _by_name(kinds)]
    return table(("effect", "parameters"), rows)


def _by_name(kinds: dict[str, EffectKind]) -> list[EffectKind]:
    return sorted(kinds.values(), key=lambda kind: kind.name)


def _parameters(kind: EffectKind) -> str:
    return "; ".join(_parameter(parameter) for parameter in kind.parameters)


def _parameter(parameter: Parameter) -> str:
    unit = "" if parameter.unit == "1" else f" [{parameter.unit}]"
    default = "" if parameter.default is None else f", default {parameter.default:g}"
    return f"`{parameter.name}`{unit} {parameter.low:g} to {parameter.high:g}{default}"


def _numbered(components: tuple[str, ...]) -> str:
    """Names that differ in a number only, by the first and the last."""
    stems = {name.rstrip("123") for name in components}
    found = [[name for name in components if name.rstrip("123") == stem] for stem in sorted(stems)]
    return ", ".join(
        f"`{names[0]}` to `{names[-1]}`" if len(names) > 1 else f"`{names[0]}`" for names in found
    )


def _columns() -> str:
    units = ", ".join(f"`{unit}`" for unit in IN_SI)
    parts = [
        "## Tables",
        "One row is one sample. `t` increases, cells may be empty, and other columns are kept. "
        "Which columns are needed depends on the machine; a message names a missing one and "
        "its substitutes.",
        table(("column", "unit", "example", "meaning"), _column_rows()),
        "## Mappings",
        "`--columns FILE` or `--set NAME=COLUMN[unit]` map other names and units to these. "
        "`deltactl inspect FILE` proposes one. Schema: `deltactl/schemas/mapping.json`. "
        "`separator` and `decimal` are detected if you leave them out. Units: "
        f"{units}.",
        *KeyTables().of(Mapping),
        "## Channels of a recording (MCAP)",
        "Each message has a `t_ns`: the run time [ns], unless its table says more.",
    ]
    shared: dict[tuple[str, str], list[str]] = {}
    for channel in CHANNELS:
        text = table(("field", "kind", "meaning"), _field_rows(channel.fields))
        shared.setdefault((channel.says, text), []).append(f"`{channel.topic}`")
    for (says, text), topics in shared.items():
        parts += [f"### {', '.join(topics)}", says, text]
    return _page("Columns and channels", *parts)


RUN_TIME = ("t_ns", "run time [ns]")
_FIRST = re.compile(r"\b(arm|motor) 1\b")
_NUMBER = re.compile(r"(?<=_)[123](?=_|$)|(?<=^)[xyz](?=_m$)")


def _field_rows(fields: Iterable[Field]) -> list[tuple[str, ...]]:
    """Rows of fields, without a time that is only the run time.

    Fields that differ in a motor's number or an axis share a row, with the words of the first.
    """
    rows: dict[str, list[Field]] = {}
    for field in fields:
        if (field.name, field.says) != RUN_TIME:
            rows.setdefault(_NUMBER.sub("#", field.name), []).append(field)
    return [
        (
            ", ".join(f"`{field.name}`" for field in alike),
            alike[0].kind,
            alike[0].says if len(alike) == 1 else _FIRST.sub(r"\1 i", alike[0].says),
        )
        for alike in rows.values()
    ]


def _column_rows() -> list[tuple[str, ...]]:
    rows: dict[tuple[str, ...], list[str]] = {}
    for name, unit in UNITS.items():
        stem = stem_of(name)
        numbered = str(stem != name)
        rows.setdefault((stem, numbered, unit), []).append(f"`{name}`")
    return [
        (", ".join(names), unit, *map(str, COLUMN_WORDS[stem]))
        for (stem, _, unit), names in rows.items()
    ]


def _socket() -> str:
    requests = [
        (
            f"`{do}`",
            ", ".join(f"`{name}`" for name in arguments),
            "in order" if do in SLOW else "at once",
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
        "Each request and each answer is one JSON object on one line; see "
        "[the service](../service.md). Schema: `deltactl/schemas/request.json`. An example: "
        '`{"id": 1, "do": "run", "job": "/var/lib/deltactl/circle.yaml"}`',
        table(("request", "arguments", "carried out", "meaning"), requests),
        "Arguments are optional, except that `run` needs `job` or `job_text`, `result` needs "
        "`job_id`, and `rename`, `delete` and `move` need all of theirs.",
        table(("argument and example", "value", "meaning"), arguments),
    )


def _states() -> str:
    names = [f"`{state.value}`" for state in State]
    return _page(
        "States of the robot",
        states_page.INTRODUCTION,
        "\n".join(f"- {rule}" for rule in states_page.RULES),
        table(("state", "meaning", "how to leave it"), states_page.states()),
        "## Next states",
        "Requests are set as `code`; the other rows are events. An empty cell: the request is "
        "refused, or the event changes nothing.",
        table(("", *names), states_page.overview()),
        "## What is called off, and what may still move",
        "An event calls off what the third column names, as far as it exists in that state. "
        "In every other case nothing is called off and nothing moves.",
        table(states_page.COLUMNS, states_page.consequences()),
    )


def _argument_row(name: str, argument: Argument) -> tuple[str, ...]:
    words = ARGUMENT_WORDS[name]
    unit = f" [{words.unit}]" if words.unit else ""
    length = " characters" if argument.type is str else ""
    value = [f"{NAMES[argument.type]}{unit}"]
    if argument.type is not bool:
        value.append(f"{argument.least:g} to {argument.most:g}{length}")
    if words.default is not None:
        value.append(f"default {json.dumps(words.default)}")
    return f"`{name}: {json.dumps(words.example)}`", ", ".join(value), words.says


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
