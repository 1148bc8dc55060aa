"""Whoever may use the robot must not read by its daemon what the service alone may read."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.file_in_force import NAMED, FileInForce
from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.named_files import CONFIG_FOLDER, TRAINED_FOLDER
from deltactl.firmware_py.planning.packed import pack, unpack
from deltactl.firmware_py.planning.prepared import InForce, prepare_here
from deltactl.firmware_py.planning.process import PlanningProcess
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError, DeltactlError, MissingFile, NetworkError

ROBOT_FILE = CONFIG_FOLDER / "zhao-2023.yaml"
ROBOT = InForce(load_robot(ROBOT_FILE), ROBOT_FILE, ROBOT_FILE.read_text())
SECRET = "name: job\npassword: hunter2\nrobot: zhao-2023.yaml\n"
JOB = """name: fast
robot: ROBOT
path: {shape: circle, centre_m: [0.0, 0.0, -0.45], radius_m: 0.05}
timing: {mode: accelerated, speed_mps: 0.2}
inverse_kinematics: KINEMATICS
"""
STEPS = "name: s\nrobot: zhao-2023.yaml\nsteps: [{include: inner.yaml}]\n" + "\n".join(
    JOB.replace("KINEMATICS", "{kind: geometry}").splitlines()[3:]
)


def job_text(robot: object = "zhao-2023.yaml", network: object = None) -> str:
    kind = "{kind: geometry}" if network is None else f"{{kind: network, file: {network}}}"
    return JOB.replace("ROBOT", str(robot)).replace("KINEMATICS", kind)


@dataclass(frozen=True)
class Place:
    """The folder of jobs that were sent to a daemon, and somebody's own folder."""

    sent: Path
    own: Path

    def refused(self, text: str, sent: bool) -> str:
        job = (self.sent if sent else self.own) / "job.yaml"
        job.write_text(text)
        with pytest.raises(DeltactlError) as refusal:
            prepare_here(job, ROBOT, FileAccess(follow=False, quote=sent))
        return str(refusal.value)


@pytest.fixture
def place(tmp_path: Path) -> Place:
    for name in ("jobs", "own"):
        (tmp_path / name).mkdir()
    return Place(tmp_path / "jobs", tmp_path / "own")


@pytest.mark.study
def test_a_job_file_shows_its_line_and_no_more_and_a_sent_text_all(place: Place) -> None:
    """Through the planner's own process, as the daemon asks it."""
    planning = PlanningProcess(most_s=60.0, sent=place.sent)
    job, sent = place.own / "job.yaml", place.sent / "job.yaml"
    for path in (job, sent):
        path.write_text(SECRET)
    try:
        with pytest.raises(ConfigError, match=r"job.yaml:\d: is not as such") as refusal:
            planning.prepare(job, ROBOT)
        assert "password" not in str(refusal.value)
        with pytest.raises(ConfigError, match="unknown key"):
            planning.prepare(sent, ROBOT)
        (link := place.own / "link.yaml").symlink_to(job)
        with pytest.raises(MissingFile, match="is reached through a link"):
            planning.prepare(link, ROBOT)
    finally:
        planning.close()


@pytest.mark.parametrize("sent", [True, False])
def test_files_that_a_job_names_show_nothing_either_way(place: Place, sent: bool) -> None:
    """Whoever sent a text wrote that, and not the files that it names."""
    secret = place.own / "secret.yaml"
    secret.write_text(SECRET)
    network = place.own / "secret.tflite"
    shutil.copy(TRAINED_FOLDER / "uzunovic-2013.tflite", network)
    for says in (
        place.refused(job_text(robot=secret), sent),
        place.refused(job_text(network=network), sent),
    ):
        assert re.search(r"secret\.\w+(:\d)?: is not as such a file should be", says)
        assert not re.search("password|hunter2|uzunovic", says)


def test_an_included_file_shows_nothing(place: Place) -> None:
    (place.sent / "inner.yaml").write_text(SECRET)
    says = place.refused(STEPS, sent=True)
    assert re.search(r"inner.yaml:\d: is not as such a file should be", says)
    assert "password" not in says


@pytest.mark.parametrize("sent", [True, False])
@pytest.mark.parametrize("names", ["robot", "network", "include"])
def test_no_link_is_followed(place: Place, names: str, sent: bool) -> None:
    whole = {"robot": ROBOT_FILE, "network": TRAINED_FOLDER / "zhao-2023.tflite"}
    folder = place.sent if sent else place.own
    inner = folder / "inner.yaml"
    inner.unlink(missing_ok=True)
    if names == "include":
        (folder / "real.yaml").write_text(job_text())
        inner.symlink_to(folder / "real.yaml")
        text = STEPS
    else:
        link = folder / f"link{whole[names].suffix}"
        link.unlink(missing_ok=True)
        copy = shutil.copy(whole[names], folder / f"copy{whole[names].suffix}")
        link.symlink_to(copy)
        text = job_text(**{names: link})
    assert "is reached through a link" in place.refused(text, sent)


def test_a_folder_s_files_are_not_listed(place: Place) -> None:
    (place.own / "not-to-be-known.yaml").write_text("")
    says = place.refused(job_text(robot="none.yaml"), sent=False)
    assert "no such file" in says
    assert "circle.yaml" in says  # of config/
    assert "not-to-be-known" not in says


def test_what_stands_in_the_program_s_folders_is_said(place: Place) -> None:
    assert "uzunovic" in place.refused(job_text(network="uzunovic-2013.tflite"), sent=True)


def test_a_network_that_was_put_in_another_s_place_is_not_opened_by_the_daemon(
    tmp_path: Path,
) -> None:
    """The daemon opens it once more, after the planner's process has."""
    network, job = tmp_path / "own.tflite", tmp_path / "job.yaml"
    shutil.copy(TRAINED_FOLDER / "zhao-2023.tflite", network)
    job.write_text(job_text(network=network))
    content = pack(prepare_here(job, ROBOT))
    network.write_bytes((TRAINED_FOLDER / "uzunovic-2013.tflite").read_bytes())
    with pytest.raises(NetworkError, match="is not as such a file should be"):
        unpack(content, ROBOT, job, FileAccess(follow=False, quote=False))
    network.unlink()
    network.symlink_to(TRAINED_FOLDER / "zhao-2023.tflite")
    with pytest.raises(MissingFile, match="is reached through a link"):
        unpack(content, ROBOT, job, FileAccess(follow=False, quote=False))


def test_a_robot_file_that_a_client_named_shows_nothing_then_nor_later(tmp_path: Path) -> None:
    own, secret = tmp_path / "own.yaml", tmp_path / "secret.yaml"
    secret.write_text(SECRET)
    own.write_text(SECRET)
    with pytest.raises(ConfigError, match="is not as such a file should be") as refusal:
        FileInForce(own, access=NAMED)
    assert "password" not in str(refusal.value)
    own.write_text(ROBOT.text)
    named = FileInForce(own, access=NAMED)
    assert named.robot == ROBOT.robot
    own.write_text(SECRET)
    says = named.changed(ROBOT.robot)
    assert "cannot be used" in says
    assert "password" not in says
    own.unlink()
    own.symlink_to(secret)
    assert "is reached through a link" in named.changed(ROBOT.robot)
    assert named.newer(ROBOT.robot) is None
    with pytest.raises(MissingFile, match="is reached through a link"):
        FileInForce(own, access=NAMED)
