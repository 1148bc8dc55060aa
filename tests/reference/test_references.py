"""The reference pages and schemas are those of the code, and the schemas take what it takes."""

from __future__ import annotations

import json

import jsonschema
import pytest
import yaml

from reference.fields import sections
from reference.schemas import schemas
from reference.write import made
from tests.rigs.documented import ROOT

FILES = sorted((ROOT / "config").glob("*.yaml"))


@pytest.mark.parametrize("path", made(), ids=lambda path: path.name)
def test_nothing_is_stale(path) -> None:
    assert path.read_text(encoding="utf-8") == made()[path], "type: make reference"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_shipped_files_fit_their_schema(path) -> None:
    data = yaml.safe_load(path.read_text(encoding="utf-8"))
    schema = json.loads(schemas()["robot.json" if "kind" in data else "job.json"])
    jsonschema.validate(_with_floats(data), schema)


def test_a_misspelt_key_does_not_fit() -> None:
    data = yaml.safe_load((ROOT / "config" / "heart.yaml").read_text(encoding="utf-8"))
    data["path"]["widht_m"] = data["path"].pop("width_m")
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data, json.loads(schemas()["job.json"]))


def test_every_key_of_a_job_says_something() -> None:
    from firmware_py.job_file import JobFile

    found = {f"{one.place}.{key.name}": key for one in sections(JobFile) for key in one.keys}
    assert found["path.radius_m"].unit == "m"
    assert found["path.radius_m"].bounds == "above 0 to 2"
    assert "no arm reaches further" in found["path.radius_m"].says
    assert found["timing.t_pwm_s"].default == "required"


def _with_floats(value):
    """PyYAML takes 1e-5 for a text, this program for a number."""
    if isinstance(value, dict):
        return {key: _with_floats(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_with_floats(inner) for inner in value]
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value
