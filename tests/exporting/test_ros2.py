"""`deltactl export`: a run as ROS 2 messages, read by libraries that did not write them."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from typer.testing import CliRunner

import deltactl as dc
from deltactl.cli.main import app
from deltactl.foundation.errors import ConfigError
from deltactl.models.linkage import Linkage, forward
from deltactl.recording.reading.reader import read_run

pytest.importorskip("rosbags", reason="the extra 'diagnosis'")
ros2_decoder = pytest.importorskip("mcap_ros2.decoder", reason="the extra 'diagnosis'")

JOB = {
    "name": "round",
    "robot": "zhao-2023.yaml",
    "path": {"shape": "circle", "centre_m": [0.0, 0.0, -0.45], "radius_m": 0.03},
    "timing": {"mode": "accelerated", "speed_mps": 0.3},
    "inverse_kinematics": {"kind": "geometry"},
}


def deltactl(*words: str) -> None:
    """A command, whose error goes through."""
    CliRunner().invoke(app, list(words), catch_exceptions=False)


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded run in its folder, and its export."""
    folder = tmp_path_factory.mktemp("ros2")
    dc.simulate(JOB, record=folder / "run.mcap", seed=1)
    deltactl("export", str(folder / "run.mcap"), str(folder / "ros2.mcap"))
    return folder


def messages(path: Path) -> tuple[dict[str, list[tuple[int, Any]]], Any]:
    """Time and message by topic, and the summary of the file."""
    found = defaultdict(list)
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[ros2_decoder.DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found[channel.topic].append((message.log_time, decoded))
        return found, reader.get_summary()


def test_joint_states_and_frames_follow_the_counts_that_were_sent(exported: Path) -> None:
    found, _ = messages(exported / "ros2.mcap")
    run, robot = read_run(exported / "run.mcap"), dc.Robot.load("zhao-2023.yaml").model
    start_ns = run.configuration.start_epoch_ns
    linkage = Linkage.of(robot.geometry)
    assert len(found["/joint_states"]) == len(found["/tf"]) > 20
    pairs = list(zip(found["/joint_states"], found["/tf"], strict=True))
    for (at_ns, state), (tf_ns, frames) in pairs[:: len(pairs) // 10]:
        assert at_ns == tf_ns == state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        counts = run.edges.counts_at(np.array([at_ns - start_ns]))[0]
        angles = counts * robot.drive.rad_per_step
        places = dict(zip(state.name, state.position, strict=True))
        np.testing.assert_allclose([places[f"motor_{n}"] for n in (1, 2, 3)], angles, atol=1e-12)
        assert len(state.velocity) == len(state.name) == 9
        np.testing.assert_allclose(
            platform_m(frames), forward(linkage, angles).position_m, atol=1e-9
        )


def platform_m(frames: Any) -> Any:
    """Where the chain of frames brings the platform, by turning vectors with the quaternions."""
    by_child = {one.child_frame_id: one for one in frames.transforms}
    place, frame = np.zeros(3), "platform"
    while frame != "base_link":
        one = by_child[frame]
        shift, turn = one.transform.translation, one.transform.rotation
        axis = np.array([turn.x, turn.y, turn.z])
        cross = 2.0 * np.cross(axis, place)
        place = place + turn.w * cross + np.cross(axis, cross) + [shift.x, shift.y, shift.z]
        frame = one.header.frame_id
    return place


def test_the_robot_is_described_once_and_for_late_subscribers(exported: Path) -> None:
    found, summary = messages(exported / "ros2.mcap")
    ((_, description),) = found["/robot_description"]
    names = {one.child_frame_id for one in found["/tf"][0][1].transforms}
    assert all(f'<link name="{name}"' in description.data for name in names)
    channels = {channel.topic: channel for channel in summary.channels.values()}
    service = {
        topic: yaml.safe_load(channel.metadata["offered_qos_profiles"])[0]
        for topic, channel in channels.items()
    }
    transient, volatile = 1, 2
    assert service["/robot_description"]["durability"] == transient
    assert service["/tf"]["durability"] == volatile
    assert {channel.message_encoding for channel in channels.values()} == {"cdr"}
    assert {schema.name for schema in summary.schemas.values()} == {
        "std_msgs/msg/String",
        "sensor_msgs/msg/JointState",
        "tf2_msgs/msg/TFMessage",
    }


def test_what_cannot_be_exported_is_refused_in_one_line(exported: Path) -> None:
    run = str(exported / "run.mcap")
    for words, says in (
        ((run, run, "--force"), "is the recording itself"),
        ((run, str(exported / "robot.urdf")), "a robot file"),
        (("stepper-axis.yaml", str(exported / "axis.xml")), "only diagnosed"),
        ((run, str(exported / "more.mcap"), "--truth"), "leave it out"),
    ):
        with pytest.raises(ConfigError, match=says):
            deltactl("export", *words)
    assert json.dumps(read_run(exported / "run.mcap").complete) == "true"


def test_a_robot_is_exported_by_its_name(tmp_path: Path) -> None:
    for name in ("robot.urdf", "robot.xml"):
        deltactl("export", "gripper-delta.yaml", str(tmp_path / name))
        assert "motor_3" in (tmp_path / name).read_text(encoding="utf-8")
