"""What a browser may send as a job."""

from __future__ import annotations

import pytest
import yaml

from deltactl.firmware_py.job_file import JobFile
from deltactl.foundation.errors import ConfigError
from deltactl.web.behind.texts import kind_of
from deltactl.web.motion_card import to_angles, to_point
from deltactl.web.state_card import in_degrees, in_millimetres

HEART = {"name": "h", "robot": "zhao-2023.yaml", "path": {"shape": "heart"}}


@pytest.mark.parametrize(
    "change",
    [
        {"robot": "../secret.yaml"},
        {"robot": "/etc/passwd"},
        {"record": "../../x.mcap"},
        {"inverse_kinematics": {"kind": "network", "file": "/tmp/evil.tflite"}},
        {"robot": "..\\x.yaml"},
        {"steps": [{"repeat": 2, "steps": [{"include": "../x.yaml"}]}]},
        {"steps": [{"job": {"inverse_kinematics": {"kind": "network", "file": "/tmp/x.tflite"}}}]},
    ],
)
def test_a_job_from_a_page_reaches_for_no_path(change: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="without folders"):
        kind_of(yaml.safe_dump(HEART | change))


def test_kinds_are_told_apart_and_long_texts_refused() -> None:
    assert kind_of(yaml.safe_dump(HEART)) == "job"
    assert kind_of("kind: delta\nname: x\n") == "robot"
    with pytest.raises(ConfigError, match="a page may send"):
        kind_of("# " + "x" * 60_000)


@pytest.mark.parametrize(
    "text",
    [to_point("r.yaml", (0.0, 0.1, -0.4)), to_angles("r.yaml", (1.0, 2.0, 3.0))],
)
def test_motions_are_jobs(text: str) -> None:
    assert JobFile.model_validate_json(yaml_as_json(text)).robot == "r.yaml"


def yaml_as_json(text: str) -> str:
    import json

    return json.dumps(yaml.safe_load(text))


def test_nothing_is_no_negative_nothing() -> None:
    assert in_millimetres((-1e-9, 0.0, -0.45)) == "0.00  0.00  -450.00 mm"
    assert in_degrees((-1e-9, 0.0, -0.1)) == "0.000  0.000  -5.730°"
