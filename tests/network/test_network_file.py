"""Files are checked before any of them is run: broken, foreign, changed, or for another robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from deltactl.foundation.errors import MissingFile, NetworkError
from deltactl.models.network import NetworkFile, fingerprint
from deltactl.models.network.file import checked_metadata
from deltactl.models.network.structure import Span, metadata_span
from deltactl.models.robot import DeltaRobot
from deltactl.models.training.graph import Graph
from deltactl.models.training.recipe import Task


def refusal(content: bytes) -> str:
    """The message with which these bytes are refused."""
    with pytest.raises(NetworkError) as caught:
        checked_metadata(content, "net.tflite")
    message = str(caught.value)
    assert message.startswith("net.tflite: ")
    assert "\n" not in message
    return message


def of_samples(file: NetworkFile, machine: str) -> NetworkFile:
    """The same file as if it had learned from samples of a machine."""
    changes = {"data": "0123456789abcdef", "machine": machine}
    training = file.metadata.training.model_copy(update=changes)
    return replace(file, metadata=file.metadata.model_copy(update={"training": training}))


@pytest.fixture
def file(write: Callable[..., NetworkFile], make_network: Callable[..., Any]) -> NetworkFile:
    return write(make_network())


def test_the_metadata_tells_robot_domain_training_and_errors(file: NetworkFile, task: Task) -> None:
    metadata = file.metadata
    assert metadata.robot.name == "bench"
    assert metadata.robot.geometry == task.robot.geometry
    assert metadata.robot.fingerprint == fingerprint(task.robot.geometry)
    assert metadata.domain == task.domain
    assert (metadata.training.seed, metadata.training.recipe) == (3, "random")
    assert metadata.parameters == 4 * 4 + 5 * 3
    assert metadata.validation.samples == 10
    # An untrained network is wrong by degrees, and says so.
    assert 1.0 < metadata.validation.rmse_deg <= metadata.validation.max_deg
    assert metadata.validation.max_deg <= metadata.validation.bound_deg


@pytest.mark.study
def test_every_single_changed_byte_is_noticed(file: NetworkFile) -> None:
    for at in range(len(file.content)):
        changed = bytearray(file.content)
        changed[at] ^= 0x55
        refusal(bytes(changed))


def test_every_shortened_file_is_refused(file: NetworkFile) -> None:
    for length in range(len(file.content)):
        refusal(file.content[:length])


def test_a_longer_file_is_refused(file: NetworkFile) -> None:
    assert "checksum" in refusal(file.content + b"\0")


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_arbitrary_bytes_are_refused(content: bytes) -> None:
    assert "TFL3" in refusal(content) or content[4:8] == b"TFL3"


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_overwritten_parts_are_refused_without_another_error(
    file: NetworkFile, data: st.DataObject
) -> None:
    at = data.draw(st.integers(0, len(file.content) - 1))
    patch = data.draw(st.binary(min_size=1, max_size=16))
    changed = file.content[:at] + patch + file.content[at + len(patch) :]
    if changed != file.content:
        refusal(changed)


def test_a_network_of_another_program_is_named_as_such(file: NetworkFile) -> None:
    span = metadata_span(file.content, "deltactl")
    assert isinstance(span, Span)
    renamed = file.content.replace(b"deltactl\0", b"somebody\0")
    assert renamed != file.content
    assert "another program" in refusal(renamed)


def test_metadata_of_another_version_is_refused() -> None:
    graph = Graph()
    source = graph.input("position_m", (1, 3))
    result = graph.fully_connected(source, np.eye(3), np.zeros(3))
    assert "format" in refusal(graph.to_bytes(source, result, "", b'{"format": 2}'))
    assert "JSON" in refusal(graph.to_bytes(source, result, "", b"{"))


def test_a_missing_file_and_a_folder_are_not_broken_networks(tmp_path: Path) -> None:
    for path in (tmp_path / "no.tflite", tmp_path):
        with pytest.raises(MissingFile, match="check the path"):
            NetworkFile.load(path)


def test_a_file_that_is_far_too_large_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("deltactl.models.network.file.LARGEST_BYTES", 10)
    path = tmp_path / "big.tflite"
    path.write_bytes(bytes(11))
    with pytest.raises(NetworkError, match="more than 10 bytes"):
        NetworkFile.load(path)


def test_a_robot_of_another_name_is_refused_naming_both(
    file: NetworkFile, make_robot: Callable[..., DeltaRobot]
) -> None:
    file.check(make_robot())
    with pytest.raises(NetworkError, match=r"'bench'.*'other'"):
        file.check(make_robot("other"))


@pytest.mark.parametrize(
    "change",
    [
        {"upper_arm_m": 0.2500001},
        {"forearm_m": (0.5, 0.5, 0.501)},
        {"platform_radius_m": 0.08},
        {"azimuth_deg": (0.0, 120.0, 240.1)},
        {"home_offset_deg": (0.0, 0.1, 0.0)},
    ],
)
def test_another_geometry_is_refused(
    file: NetworkFile, make_robot: Callable[..., DeltaRobot], change: dict[str, Any]
) -> None:
    with pytest.raises(NetworkError, match=r"another geometry.*train it again"):
        file.check(make_robot(**change))


def test_a_network_of_measured_samples_runs_with_the_calibration_of_its_robot(
    file: NetworkFile, make_robot: Callable[..., DeltaRobot]
) -> None:
    """The machine is the same; a network of the designed geometry is of the design alone."""
    designed = fingerprint(make_robot().geometry)
    changes = {"calibrated_from": designed, "calibrated_on": "robot"}
    found = make_robot(forearm_m=(0.5, 0.5, 0.501)).model_copy(update=changes)
    measured = of_samples(file, "robot")
    measured.check(found)
    measured.check(make_robot())
    with pytest.raises(NetworkError, match="another geometry"):
        file.check(found)
    with pytest.raises(NetworkError, match=r"'bench'.*'other'"):
        measured.check(found.model_copy(update={"name": "other"}))
    other_design = found.model_copy(update={"calibrated_from": "0123456789abcdef"})
    with pytest.raises(NetworkError, match="another geometry"):
        measured.check(other_design)


@pytest.mark.parametrize("machine", ["simulated", "as-built workshop.yaml 1234", ""])
def test_the_calibration_of_another_machine_of_the_same_design_is_refused(
    file: NetworkFile, make_robot: Callable[..., DeltaRobot], machine: str
) -> None:
    changes = {"calibrated_from": fingerprint(make_robot().geometry), "calibrated_on": "robot"}
    found = make_robot(forearm_m=(0.5, 0.5, 0.501)).model_copy(update=changes)
    with pytest.raises(NetworkError, match=f"'{machine}'.*'robot'.*--save-robot"):
        of_samples(file, machine).check(found)


def test_the_same_linkage_written_differently_has_the_same_fingerprint(
    make_robot: Callable[..., DeltaRobot],
) -> None:
    plain = make_robot().geometry
    wordy = make_robot(
        base_radius_m=(0.425, 0.425, 0.425),
        platform_radius_m=0.175,
        upper_arm_m=(0.25, 0.25, 0.25),
        azimuth_deg=(360.0, 120.0, -120.0),
        home_offset_deg=(-0.0, 0.0, 0.0),
    ).geometry
    assert fingerprint(plain) == fingerprint(wordy)
