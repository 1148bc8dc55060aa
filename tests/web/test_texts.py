"""What a browser may send as a job."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from deltactl.firmware_py.job_file import JobFile
from deltactl.foundation.errors import ConfigError
from deltactl.web.behind.own_jobs import OwnJobs
from deltactl.web.behind.texts import kind_of, mistakes
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


def test_each_mistake_is_marked_where_it_is() -> None:
    text = "name: x\nrobot: r.yaml\npath: {shape: heart, centre_m: [0, 0, -0.4], width_m: 0.1}\n"
    good = text + "timing: {mode: accelerated, speed_mps: 0.1}\n"
    good += "inverse_kinematics: {kind: geometry}\n"
    assert mistakes(good, "x.yaml") == []
    wrong = good.replace("heart", "hart").replace("speed_mps", "sped_mps")
    assert {mistake.line for mistake in mistakes(wrong, "x.yaml")} == {3, 4}
    (broken,) = mistakes("name: x\npath: [1, 2\n", "x.yaml")
    assert broken.line > 0
    (outside,) = mistakes(good.replace("r.yaml", "../r.yaml"), "x.yaml")
    assert outside.line == 2
    assert "x.yaml" not in outside.says


@pytest.mark.parametrize("name", ["../x", "a/b", ".x", "", "x\ny", "a\\b", "x" * 60, "heart"])
def test_a_job_is_kept_under_a_plain_name_of_its_own(name: str, tmp_path: Path) -> None:
    jobs = OwnJobs(tmp_path / "jobs", lambda: ["heart.yaml"])
    assert jobs.save("mine", "name: a\n") == "mine.yaml"
    for call in (lambda: jobs.save(name, "x"), lambda: jobs.rename("mine.yaml", name)):
        with pytest.raises(ConfigError):
            call()
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["mine.yaml"]


def test_a_renamed_job_replaces_no_other(tmp_path: Path) -> None:
    jobs = OwnJobs(tmp_path, list)
    jobs.save("a", "name: a\n")
    jobs.save("b", "name: b\n")
    with pytest.raises(ConfigError, match="there is such a job already"):
        jobs.rename("a.yaml", "b")
    assert jobs.rename("a.yaml", "c 1") == "c 1.yaml"
    jobs.delete("b.yaml")
    assert {name: jobs.read(name) for name in jobs.files()} == {"c 1.yaml": "name: a\n"}
    with pytest.raises(ConfigError, match="no such job"):
        jobs.delete("../c 1.yaml")


def test_nothing_is_no_negative_nothing() -> None:
    assert in_millimetres((-1e-9, 0.0, -0.45)) == "0.00  0.00  -450.00 mm"
    assert in_degrees((-1e-9, 0.0, -0.1)) == "0.000  0.000  -5.730°"
