"""Foxglove's messages, read back with the official MCAP reader and its protobuf decoder."""

from __future__ import annotations

import base64
import json
import math
import time
from contextlib import suppress
from importlib.resources import files
from pathlib import Path
from typing import Any

import foxglove.messages
import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from websockets.sync.client import ClientConnection, connect

from deltactl.firmware_py.controller.contract import SensorStatus, Status
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import RecordingError
from deltactl.models.linkage.skeleton import quaternion
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.writing.writer import RunRecorder
from deltactl.web.behind.known_robots import KnownRobots
from deltactl.web.behind.link import Seen
from deltactl.web.foxglove import LiveServer, convert

ROBOT = CONFIG_FOLDER / "zhao-2023.yaml"
HOME = (1333, 1333, 1333)


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seconds of a robot that stands at its home, as Foxglove gets it."""
    folder = tmp_path_factory.mktemp("fox")
    text = ROBOT.read_text(encoding="utf-8")
    run = folder / "run.mcap"
    with RunRecorder(run, RunConfiguration(text, "", "zhao-2023", "test"), counts=HOME) as recorder:
        recorder.event(0, "path_start", "begins")
        for t_ns in range(0, 2_000_000_000, 20_000_000):
            recorder.commanded(t_ns, HOME)
    assert read_run(run).end_ns > 0
    convert(run, folder / "fox.mcap")
    with pytest.raises(RecordingError, match="exists already"):
        convert(run, folder / "fox.mcap")
    return folder / "fox.mcap"


def test_a_recording_carries_well_known_schemas(converted: Path) -> None:
    with converted.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    names = {summary.schemas[one.schema_id].name for one in summary.channels.values()}
    assert {"foxglove.FrameTransforms", "foxglove.SceneUpdate", "foxglove.PoseInFrame",
            "foxglove.LaserScan", "foxglove.Log"} >= names  # fmt: skip
    assert {"foxglove.FrameTransforms", "foxglove.SceneUpdate", "foxglove.Log"} <= names


def test_the_scene_is_the_robot(converted: Path) -> None:
    """Its rods have the robot's lengths, and the platform is where the linkage puts it."""
    with converted.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = {channel.topic: message for _, channel, _, message in
                 reader.iter_decoded_messages()}  # fmt: skip
    (robot,) = found["/robot"].entities
    lengths = sorted(round(part.size.z, 3) for part in robot.cylinders)
    assert lengths == [0.012, 0.012, 0.25, 0.25, 0.25, *[0.5] * 6]
    (platform,) = [one for one in found["/tf"].transforms if one.child_frame_id == "platform"]
    place = found["/pose/commanded"].pose.position
    assert (platform.translation.x, platform.translation.y) == pytest.approx((0, 0), abs=1e-9)
    assert platform.translation.z == place.z < -0.3
    assert found["/log"].message == "begins"


@pytest.mark.parametrize("seed", range(20))
def test_quaternions_turn_as_their_matrix(seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    matrix = matrix * np.sign(np.linalg.det(matrix))
    *imaginary, w = quaternion(matrix.tolist())
    vector = rng.standard_normal(3)
    u = np.array(imaginary)
    turned = vector + 2.0 * np.cross(u, np.cross(u, vector) + w * vector)
    assert turned == pytest.approx(matrix @ vector, abs=1e-9)
    assert math.hypot(*imaginary, w) == pytest.approx(1.0)


class OneStatus:
    """A link that has heard one status."""

    def __init__(self, status: Status):
        self.seen = Seen(1, time.monotonic(), status, "")


SENT = {"/tf", "/robot", "/measured_ball", "/pose/target", "/pose/commanded", "/pose/measured",
        "/log", "/range/x", "/range/y", "/range/z"}  # fmt: skip


def decoder(name: str, schema: bytes) -> Any:
    """An empty message as a viewer makes it from the schema that it is given."""
    pool = descriptor_pool.DescriptorPool()
    for one in descriptor_pb2.FileDescriptorSet.FromString(schema).file:
        pool.Add(one)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(name))()


def test_the_live_server_announces_official_schemas_and_sends_what_they_decode() -> None:
    sensors = tuple(SensorStatus(axis, 0.6, 0.01, "good", 9.0, "ok") for axis in "xyz")
    status = Status("ready", "", "zhao-2023", True, 1.0, HOME, None, None, None, None, 0.0, None,
                    (), None, "", 0, sensors, target_m=(0.01, 0.02, -0.45))  # fmt: skip
    server = LiveServer(OneStatus(status), KnownRobots(), "127.0.0.1", 0)  # type: ignore[arg-type]
    try:
        server.look()
        with connect(f"ws://127.0.0.1:{server.port}", subprotocols=["foxglove.sdk.v1"]) as viewer:  # type: ignore[list-item]
            said = [json.loads(viewer.recv(timeout=30.0)) for _ in range(2)]
            offered = {one["topic"]: one for told in said if told["op"] == "advertise"
                       for one in told["channels"]}  # fmt: skip
            assert offered.keys() == SENT
            assert offered["/robot"]["schemaName"] == "foxglove.SceneUpdate"
            ids = {one["id"]: one for one in offered.values()}
            ask = {"op": "subscribe",
                   "subscriptions": [{"id": one, "channelId": one} for one in ids]}  # fmt: skip
            viewer.send(json.dumps(ask))
            found = heard(server, viewer, ids)
    finally:
        server.close()
    assert len(found["/robot"].entities[0].cylinders) == 11
    assert found["/pose/measured"].frame_id == "base"
    target = found["/pose/target"].pose.position
    assert (target.x, target.y, target.z) == (0.01, 0.02, -0.45)
    assert found["/range/z"].ranges[0] == pytest.approx(0.6)


def decoded(channel: dict[str, Any], content: bytes) -> Any:
    """A message by the schema that came with its channel, which must be Foxglove's own."""
    name, schema = channel["schemaName"], base64.b64decode(channel["schema"] + "==")
    own = getattr(foxglove.messages, name.removeprefix("foxglove.")).get_schema()
    assert schema == own.data
    one = decoder(name, schema)
    one.ParseFromString(content)
    return one


def heard(server: LiveServer, viewer: ClientConnection, ids: dict[int, Any]) -> dict[str, Any]:
    """A message of every topic that is sent."""
    found: dict[str, Any] = {}
    give_up_s = time.monotonic() + 30.0
    while found.keys() < SENT:
        assert time.monotonic() < give_up_s, f"only {sorted(found)} came"
        server._last, server._state = -1, ""
        server.look()
        with suppress(TimeoutError):
            while True:  # what comes before the server knows of the subscription is lost
                message = viewer.recv(timeout=0.05)
                if isinstance(message, bytes):
                    channel = ids[int.from_bytes(message[1:5], "little")]
                    found[channel["topic"]] = decoded(channel, message[13:])
    return found


def test_the_layout_names_topics_that_exist(converted: Path) -> None:
    layout = json.loads((files("deltactl.web") / "foxglove_layout.json").read_text())
    with converted.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    there = {one.topic for one in summary.channels.values()}
    there |= {"/range/x", "/range/y", "/range/z", "/measured_ball", "/pose/target"}
    assert set(layout["configById"]["3D!robot"]["topics"]) <= there
