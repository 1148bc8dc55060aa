"""The four tools of an assistant: what each takes, and what it is for."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

LONGEST_TEXT = 20_000
"""Letters of a robot file in a call: the longest shipped one has a fifth of them, and the words of
a process, in which they are handed on, have a bound."""
MOST_FILES = 20
"""Recordings of one diagnosis, as many as the diagnosis itself takes at most."""
Name = Annotated[str, Field(min_length=1, max_length=4096)]
Columns = Annotated[
    list[Annotated[str, Field(max_length=1000)]] | None,
    Field(
        default=None,
        max_length=100,
        description="How columns are read, as `inspect` proposes them: ['t=time[ms]',"
        " 'position=angle[deg]']. Leave it out where the file has the program's own names.",
    ),
]
Diagnosed = Annotated[
    str, Field(min_length=1, max_length=20, description="Name of a diagnosis, as its answer says.")
]


class Call(BaseModel):
    """Arguments of a tool: what it does not know is refused."""

    model_config = ConfigDict(extra="forbid")


class Inspect(Call):
    """Show what a recording contains: machine, columns, units, and how `diagnose` reads it. Call it
    first for a table with names of its own."""

    recording: Annotated[Name, Field(description="File below the root: CSV, Parquet, MAT, MCAP.")]
    columns: Columns = None


class Diagnose(Call):
    """Find out where recordings of a machine differ from its robot file, why, and how surely. Takes
    seconds, at most a few minutes; reports progress and can be cancelled."""

    recordings: Annotated[
        list[Name], Field(min_length=1, max_length=MOST_FILES, description="Of one machine.")
    ]
    robot: Annotated[
        Name | None,
        Field(description="Robot file below the root, or the name of one that deltactl ships."),
    ] = None
    robot_text: Annotated[
        str | None,
        Field(
            max_length=LONGEST_TEXT,
            description="The text of a robot file instead: '{kind: servo_axis, name: axis, motion:"
            " rotary}' is one whole, for an axis with commands and positions.",
        ),
    ] = None
    columns: Columns = None
    holdout: Annotated[
        list[Name],
        Field(max_length=MOST_FILES, description="Recordings to test the answer on."),
    ] = []

    @model_validator(mode="after")
    def _one_robot(self) -> Diagnose:
        if (self.robot is None) == (self.robot_text is None):
            raise ValueError("say either robot (a file) or robot_text (its text)")
        return self


class Explain(Call):
    """Explain one finding of a diagnosis: sizes and intervals, where it shows, how sure it is, what
    else it could be, what to do."""

    diagnosis: Diagnosed
    finding: Annotated[int, Field(ge=1, description="Its number in the answer, from 1.")]


class NextRun(Call):
    """Propose what settles what a diagnosis left open: a job for a delta, else a motion or a
    measurement; and list what the recording could not show."""

    diagnosis: Diagnosed


TOOLS: dict[str, type[Call]] = {
    "inspect": Inspect,
    "diagnose": Diagnose,
    "explain": Explain,
    "next_run": NextRun,
}


def described() -> list[dict[str, Any]]:
    """Name, purpose and JSON Schema of each tool."""
    return [
        {
            "name": name,
            "description": " ".join(str(arguments.__doc__).split()),
            "input_schema": arguments.model_json_schema(),
        }
        for name, arguments in TOOLS.items()
    ]
