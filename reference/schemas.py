"""JSON Schemas for editors and for other programs."""

from __future__ import annotations

import json
from typing import Any

from pydantic import TypeAdapter

from diagnosis.columns.mapping import Mapping
from firmware_py.daemon.protocol import ARGUMENTS
from firmware_py.job_file import JobFile
from firmware_py.robot_file import RobotFile
from models.robot import RangeSensor, ServoAxis, StepperAxis

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TYPES = {str: "string", int: "integer", float: "number"}


def schemas() -> dict[str, str]:
    """Text of each schema by its name under schemas/."""
    robots: TypeAdapter[Any] = TypeAdapter(RobotFile | StepperAxis | ServoAxis | RangeSensor)
    made = {
        "job.json": ("A job of deltactl", JobFile.model_json_schema()),
        "robot.json": ("A robot file of deltactl", robots.json_schema()),
        "mapping.json": ("How a table of somebody else is read", Mapping.model_json_schema()),
        "request.json": ("A request to the daemon", _request()),
    }
    return {
        name: json.dumps({"$schema": DIALECT, **schema, "title": title}, indent=1) + "\n"
        for name, (title, schema) in made.items()
    }


def _request() -> dict[str, Any]:
    return {
        "oneOf": [
            {
                "type": "object",
                "properties": {
                    "id": {"type": ["integer", "string", "null"]},
                    "do": {"const": do},
                    **{name: _argument(one) for name, one in arguments.items()},
                },
                "required": ["do"],
                "additionalProperties": False,
            }
            for do, arguments in ARGUMENTS.items()
        ]
    }


def _argument(one: Any) -> dict[str, Any]:
    if one.type is str:
        return {"type": "string", "minLength": int(one.least), "maxLength": int(one.most)}
    return {"type": TYPES[one.type], "minimum": one.least, "maximum": one.most}
