"""Logs of others: MCAP with ROS 2 or JSON messages, ROS 2 bags, LeRobot data sets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.rigs import needs
from tests.rigs.owners_words import owner_says

pytest.importorskip("pyarrow", reason=needs.LOGS)
pytest.importorskip("mcap_ros2", reason=needs.LOGS)
pytest.importorskip("rosbags", reason=needs.LOGS)

import pyarrow as pa
import pyarrow.parquet as pq
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2
from mcap.writer import Writer as JsonWriter
from mcap_protobuf.writer import Writer as ProtobufWriter
from mcap_ros2.writer import Writer as RosWriter
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped

ROWS = 400
T_S = 0.02 * np.arange(ROWS)
START_NS = 1_700_000_000_000_000_000
COMMAND = 0.7 * np.sin(1.5 * T_S)
POSITION = np.interp(T_S - 0.06, T_S, COMMAND)
STAMP = "builtin_interfaces/Time stamp\nstring frame_id"
JOINT_STATE = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
{STAMP}
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
OPTIONS = [
    "t=/joint_states.header.stamp", "position=/joint_states.position.elbow", "command=/target.data"
]  # fmt: skip


def stamp(t_s: float) -> dict[str, int]:
    return {"sec": 1_700_000_000 + int(t_s), "nanosec": round(t_s % 1.0 * 1e9)}


def joints(row: int) -> dict[str, Any]:
    return {
        "header": {"stamp": stamp(T_S[row]), "frame_id": ""}, "name": ["base", "elbow"],
        "position": [0.1, float(POSITION[row])], "velocity": [], "effort": [0.0, 0.5],
    }  # fmt: skip


def write_mcap(path: Path) -> None:
    """Commands at half the rate of the readings, logged between them."""
    with path.open("wb") as file, RosWriter(file) as writer:
        state = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        number = writer.register_msgdef("std_msgs/msg/Float64", "float64 data")
        for row, t_s in enumerate(T_S):
            at = START_NS + round(t_s * 1e9)
            writer.write_message("/joint_states", state, joints(row), at, at)
            if row % 2 == 0:
                writer.write_message("/target", number, {"data": float(COMMAND[row])}, at, at)


def write_json_mcap(path: Path) -> None:
    with path.open("wb") as file:
        writer = JsonWriter(file)
        writer.start()
        schema = writer.register_schema("joint", "jsonschema", b"{}")
        ids = {
            topic: writer.register_channel(topic, "json", schema)
            for topic in ("/joint_states", "/target")
        }
        for row, t_s in enumerate(T_S):
            at = START_NS + round(t_s * 1e9)
            for topic, data in (
                ("/joint_states", joints(row)),
                ("/target", {"data": COMMAND[row]}),
            ):
                writer.add_message(ids[topic], at, json.dumps(data).encode(), at)
        writer.finish()


def write_bag(path: Path) -> None:
    _write_bag(BagWriter(path, version=9), Stores.ROS2_HUMBLE, "serialize_cdr", [])


def write_ros_1_bag(path: Path) -> None:
    _write_bag(Ros1Writer(path), Stores.ROS1_NOETIC, "serialize_ros1", [0])


def _write_bag(
    bag: BagWriter | Ros1Writer, types: Stores, serialize: str, before_time: list[int]
) -> None:
    """before_time: what a header of these types has before its time (ROS 1: a number)."""
    store = get_typestore(types)
    kinds = store.types
    time_of, header = kinds["builtin_interfaces/msg/Time"], kinds["std_msgs/msg/Header"]
    state, number = kinds["sensor_msgs/msg/JointState"], kinds["std_msgs/msg/Float64"]
    with bag as writer:
        on = {
            name: writer.add_connection(name, kind.__msgtype__, typestore=store)
            for name, kind in (("/joint_states", state), ("/target", number))
        }
        for row, t_s in enumerate(T_S):
            at = START_NS + round(t_s * 1e9)
            said = joints(row)
            lists = {key: np.array(said[key]) for key in ("position", "velocity", "effort")}
            heading = header(*before_time, time_of(**stamp(t_s)), "")
            message = state(heading, name=said["name"], **lists)
            for name, one in (("/joint_states", message), ("/target", number(float(COMMAND[row])))):
                writer.write(on[name], at, getattr(store, serialize)(one, one.__msgtype__))


def protobuf_kinds() -> tuple[Any, Any]:
    """Message classes of a state (stamp, names, positions) and of a number."""
    file = descriptor_pb2.FileDescriptorProto(
        name="logs.proto",
        package="logs",
        syntax="proto3",
        dependency=[timestamp_pb2.DESCRIPTOR.name],
    )
    field = descriptor_pb2.FieldDescriptorProto
    one, many = field.LABEL_OPTIONAL, field.LABEL_REPEATED
    state = file.message_type.add(name="State")
    kind = ".google.protobuf.Timestamp"
    state.field.add(name="stamp", number=1, label=one, type=field.TYPE_MESSAGE, type_name=kind)
    state.field.add(name="name", number=2, label=many, type=field.TYPE_STRING)
    state.field.add(name="position", number=3, label=many, type=field.TYPE_DOUBLE)
    state.field.add(
        name="before", number=4, label=one, type=field.TYPE_MESSAGE, type_name=".logs.State"
    )
    file.message_type.add(name="Number").field.add(
        name="data", number=1, label=one, type=field.TYPE_DOUBLE
    )
    pool = descriptor_pool.DescriptorPool()
    pool.AddSerializedFile(timestamp_pb2.DESCRIPTOR.serialized_pb)
    pool.Add(file)
    names = ("logs.State", "logs.Number")
    found = [message_factory.GetMessageClass(pool.FindMessageTypeByName(name)) for name in names]
    return found[0], found[1]


def write_protobuf_mcap(path: Path) -> None:
    state, number = protobuf_kinds()
    with path.open("wb") as file, ProtobufWriter(file) as writer:
        for row, t_s in enumerate(T_S):
            at = START_NS + round(t_s * 1e9)
            said, when = joints(row), stamp(t_s)
            message = state(name=said["name"], position=said["position"])
            message.stamp.seconds, message.stamp.nanos = when["sec"], when["nanosec"]
            writer.write_message("/joint_states", message, at, at)
            writer.write_message("/target", number(data=float(COMMAND[row])), at, at)


NAMED = {write_bag: "bag", write_ros_1_bag: "log.bag"}


@pytest.mark.parametrize(
    "write", [write_mcap, write_json_mcap, write_bag, write_ros_1_bag, write_protobuf_mcap]
)
def test_by_topic_and_field(tmp_path: Path, write) -> None:
    path = tmp_path / NAMED.get(write, "log.mcap")
    write(path)
    stamped = write is not write_protobuf_mcap
    options = [one if stamped else one.replace("header.stamp", "stamp") for one in OPTIONS]
    read = read_mapped(path, load_mapping(None, options))
    np.testing.assert_allclose(read.t_s - read.t_s[0], T_S, atol=1e-6)
    np.testing.assert_allclose(read.column("position"), POSITION, atol=1e-9)
    known = np.isfinite(read.column("command"))
    assert known.sum() >= ROWS - 1
    np.testing.assert_allclose(read.column("command")[known], COMMAND[known], atol=2e-3)


def test_a_log_is_inspected(tmp_path: Path) -> None:
    write_mcap(tmp_path / "log.mcap")
    found = inspect(tmp_path / "log.mcap")
    assert dict(found.facts)["topics"] == "/joint_states, /target"
    assert found.guesses["/joint_states.header.stamp"].name == "t"
    assert found.guesses["/target.data"].name == "command"


def test_a_topic_that_is_not_there_names_those_that_are(tmp_path: Path) -> None:
    write_mcap(tmp_path / "log.mcap")
    mapping = load_mapping(
        None, ["t=/joints.header.stamp", "position=/joint_states.position.elbow"]
    )
    with pytest.raises(RecordingError, match="has no topic /joints; it has /joint_states, /target"):
        read_mapped(tmp_path / "log.mcap", mapping)


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n\x01", b"no log at all"])
def test_a_log_that_is_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "log.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=r"log\.mcap"):
        inspect(tmp_path / "log.mcap")


def test_a_lerobot_data_set(tmp_path: Path) -> None:
    """Action against observation; times start again with every episode."""
    half = ROWS // 2
    command, position = np.degrees(COMMAND), np.degrees(POSITION)
    six = range(6)
    path = tmp_path / "episodes.parquet"
    pq.write_table(
        pa.table({
            "action": [[float(c) * (j + 1) for j in six] for c in command],
            "observation.state": [[float(p) * (j + 1) for j in six] for p in position],
            "timestamp": np.concatenate([T_S[:half], T_S[:half]]).astype(np.float32),
            "frame_index": np.arange(ROWS) % half, "episode_index": np.arange(ROWS) // half,
            "index": np.arange(ROWS), "task_index": np.zeros(ROWS, dtype=int),
        }),
        path,
    )  # fmt: skip
    found = inspect(path)
    taken = {guess.name: guess.source for guess in found.guesses.values()}
    assert taken["t"] == "timestamp"
    assert taken["command"] == "action.0"
    assert taken["position"] == "observation.state.0"
    assert taken["segment"] == "episode_index"
    assert any("more joints" in warning for warning in found.warnings)
    options = owner_says(found)
    read = read_mapped(path, load_mapping(None, options))
    np.testing.assert_allclose(read.column("command"), COMMAND, atol=1e-6)
    assert (np.diff(read.t_s) > 0).all()
    assert len(read.stretches()) == 2
