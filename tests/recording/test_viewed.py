"""Recordings open in Foxglove's 3D panel as they are: official reader, official schemas."""

from __future__ import annotations

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import foxglove.messages
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, json_format, message_factory
from mcap.reader import make_reader

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.firmware_py.controller.jobs.view import View
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.recording.format.channels import SCHEMAS, VIEWED
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.writing.writer import RunRecorder

ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"
HOME = (1333, 1333, 1333)
SECOND_NS = 1_000_000_000


def reading(axis: str, t_ns: int, distance_m: float) -> Reading:
    return Reading(axis, t_ns, distance_m, 0, 9, 10.0, 0.1, 0.002, 1, Gate.GOOD)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seconds at the home position, told at 50 Hz."""
    path = tmp_path_factory.mktemp("viewed") / "run.mcap"
    text = ROBOT.read_text(encoding="utf-8")
    with RunRecorder(path, RunConfiguration(text, "", "zhao-2023", "test"), counts=HOME) as file:
        view = View(load_robot(ROBOT), file)
        view.begin(0, HOME)
        view.event(0, "path_start", "begins")
        view.event(0, "fault", "")
        for t_ns in range(0, 2 * SECOND_NS, SECOND_NS // 50):
            view.counts(t_ns, HOME)
            view.target(t_ns, (0.0, 0.0, -0.45))
            for axis, distance_m in zip("xyz", (0.6, 0.6, 0.45), strict=True):
                view.reading(reading(axis, t_ns, distance_m))
    return path


def messages(path: Path) -> list[tuple[str, str, dict[str, Any]]]:
    """Topic, schema and content of what viewers draw, by the official reader."""
    with path.open("rb") as file:
        return [
            (channel.topic, schema.name, json.loads(message.data))
            for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages()
            if schema is not None and schema.name.startswith("foxglove.")
        ]


def official(name: str) -> Any:
    """An empty message of Foxglove's own definition."""
    schema = getattr(foxglove.messages, name.removeprefix("foxglove.")).get_schema()
    pool = descriptor_pool.DescriptorPool()
    for one in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(one)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(name))()


def protobuf_times(value: Any) -> Any:
    """Foxglove's JSON writes times as sec and nsec, protobuf's as text."""
    if isinstance(value, list):
        return [protobuf_times(one) for one in value]
    if not isinstance(value, dict):
        return value
    found = {}
    for name, part in value.items():
        if name == "timestamp":
            found[name] = f"{datetime.fromtimestamp(part['sec'], UTC):%Y-%m-%dT%H:%M:%SZ}"
        elif name == "lifetime":
            found[name] = f"{part['sec']}s"
        else:
            found[name] = protobuf_times(part)
    return found


def test_every_topic_is_there_and_every_field_is_one_of_the_official_definition(
    recorded: Path,
) -> None:
    found = messages(recorded)
    assert {topic for topic, _, _ in found} == {channel.topic for channel in VIEWED}
    assert {name for _, name, _ in found} == set(SCHEMAS)
    for _, name, content in found:
        json_format.ParseDict(protobuf_times(content), official(name))
        assert set(content) == set(SCHEMAS[name]["properties"])


def objects(schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Every object within a JSON schema."""
    if schema["type"] == "object":
        yield schema
        for child in schema.get("properties", {}).values():
            yield from objects(child)
    elif schema["type"] == "array":
        yield from objects(schema["items"])


def test_every_object_of_a_schema_names_its_properties(recorded: Path) -> None:
    """Foxglove's reader of JSON schemas does not take one without, and draws nothing."""
    with recorded.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for schema in summary.schemas.values():
        for one in objects(json.loads(schema.data)):
            assert "properties" in one, f"{schema.name}: {one}"


def test_ten_times_a_second_and_the_scene_once(recorded: Path) -> None:
    topics = [topic for topic, _, _ in messages(recorded)]
    assert topics.count("/robot") == 1
    for topic in ("/pose/target", "/pose/commanded", "/pose/measured", "/range/x"):
        assert topics.count(topic) == pytest.approx(20, abs=1)


def test_frames_hold_the_robot_together(recorded: Path) -> None:
    found = messages(recorded)
    [scene] = [content for topic, _, content in found if topic == "/robot"]
    frames = {
        one["child_frame_id"]: one
        for topic, _, content in found
        if topic == "/tf"
        for one in content["transforms"]
    }
    assert {one["frame_id"] for one in scene["entities"]} <= {*frames, "base"}
    [measured, *_] = [content for topic, _, content in found if topic == "/pose/measured"]
    place = measured["pose"]["position"]
    assert (place["x"], place["y"], place["z"]) == pytest.approx((0.0, 0.0, -0.45), abs=1e-6)
    platform = frames["platform"]["translation"]
    assert (platform["x"], platform["y"]) == pytest.approx((0, 0), abs=1e-6)
    elbow, wrist = (frames[f"{part}_1"]["translation"] for part in ("arm", "forearm"))
    assert elbow["x"] > wrist["x"] > 0.0 > elbow["z"] > wrist["z"] > platform["z"]


def test_what_viewers_draw_is_not_read_back(recorded: Path) -> None:
    run = read_run(recorded)
    assert len(run.targets.t_ns) == 0
    assert run.damage == ()
