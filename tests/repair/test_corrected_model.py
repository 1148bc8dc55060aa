"""A model that was corrected by a recording lacks nothing of it, in any simulator."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.proofs.measured_arm import Hidden, measured, place, table
from benchmarks.proofs.measured_arm import urdf_text as six_joint_urdf
from deltactl.cli.main import app
from deltactl.cli.recordings.init_chain import chain
from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.api import diagnose
from tests.diagnosis.test_chain_of_joints import (
    FRICTION_NM,
    JOINTS,
    LOAD_AT,
    LOAD_KG,
    recorded,
    urdf_text,
)

mujoco = pytest.importorskip("mujoco")


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "arm.urdf").write_text(urdf_text())
    chain(tmp_path / "arm.yaml", tmp_path / "arm.urdf")
    return tmp_path / "arm.yaml"


def _export(source: Path, out: Path) -> str:
    done = CliRunner().invoke(app, ["export", str(source), str(out)])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.study
@pytest.mark.parametrize("suffix", [".urdf", ".xml"])
def test_a_model_corrected_by_poses_has_zeros_and_lengths_in_it(
    tmp_path: Path, suffix: str
) -> None:
    hidden = Hidden()
    hidden.home_rad[2:4], hidden.off[4, 2], hidden.off[2, 3] = 0.015, 0.002, 0.003
    model_file = (tmp_path / "arm").with_suffix(suffix)
    drawn = six_joint_urdf()
    if suffix == ".xml":
        spec = mujoco.MjSpec.from_string(drawn)
        spec.compile()
        drawn = spec.to_xml()
    model_file.write_text(drawn)
    robot, out = tmp_path / "arm.yaml", tmp_path / f"corrected{suffix}"
    chain(robot, model_file)
    run = table(tmp_path, measured(hidden, 120))
    corrected = tmp_path / "found.yaml"
    save_corrected(robot, diagnose([run], robot), corrected)
    _export(corrected, out)
    assert "effects:" not in out.with_suffix(".yaml").read_text()
    after = diagnose([run], out.with_suffix(".yaml"))
    assert after.findings == []
    assert after.fit.rms_before_m < 1.2 * hidden.noise_m
    # Another simulator's tip is where the arm's own is, but for its base and its reflector.
    model = mujoco.MjModel.from_xml_path(str(out))
    data, apart = mujoco.MjData(model), []
    for angles in np.random.default_rng(0).uniform(-1.0, 1.0, (3, 6)):
        data.qpos[:] = angles
        mujoco.mj_kinematics(model, data)
        body = model.body("link_flange").id
        true, _ = place(angles + hidden.home_rad, hidden)
        apart.append(data.xpos[body] + data.xmat[body].reshape(3, 3) @ hidden.tool_m - true)
    assert np.ptp(apart, axis=0).max() < 2e-4


@pytest.mark.study
def test_the_corrected_urdf_explains_the_recording(robot: Path) -> None:
    run = recorded(robot.parent, FRICTION_NM, LOAD_KG)
    corrected = robot.with_name("found.yaml")
    save_corrected(robot, diagnose([run], robot), corrected)
    out = robot.with_name("corrected.urdf")
    _export(corrected, out)
    before, after = diagnose([run], robot).fit, diagnose([run], out.with_suffix(".yaml"))
    assert after.fit.rms_before_m < 0.05 * before.rms_before_m
    # Of a load that turns as well as weighs the centre is not all: some percent of it are left.
    for finding in after.findings:
        assert finding.effect == "payload"
        assert abs(finding.parameters["mass"].components[0][0]) < 0.1 * LOAD_KG
    model = mujoco.MjModel.from_xml_path(str(out))
    friction = model.joint("shoulder").frictionloss[0]
    assert friction == pytest.approx(FRICTION_NM, rel=0.03)
    bare = mujoco.MjModel.from_xml_path(str(robot.with_name("arm.urdf")))
    more = float(model.body_mass.sum() - bare.body_mass.sum())
    assert more == pytest.approx(LOAD_KG, rel=0.1)
    # The load hangs where it was hidden: the whole centre of mass moves towards it by so much.
    tip = bare.body("body_elbow").id
    own_kg = bare.body_mass[tip]
    centre = (own_kg * bare.body_ipos[tip] + LOAD_KG * LOAD_AT) / (own_kg + LOAD_KG)
    assert np.allclose(model.body("body_elbow").ipos, centre, atol=0.02)


def _with_effects(robot: Path, *entries: str) -> Path:
    file = robot.with_name("known.yaml")
    file.write_text(robot.read_text() + "effects:\n" + "".join(f"- {one}\n" for one in entries))
    return file


RUB = "{effect: joint_friction, component: waist, parameters: {torque: 0.5}}"
BRAKE = "{effect: viscous_friction, component: elbow, parameters: {coefficient: 0.2}}"
LATE = "{effect: following_lag, component: waist, parameters: {dead_time: 0.004}}"
ROTOR = "{effect: inertia, component: waist, parameters: {inertia: 0.3}}"
GAIN = "{effect: effort_gain, component: elbow, parameters: {scale: 1.1}}"


def test_what_a_urdf_has_no_place_for_stays_in_the_robot_file(robot: Path) -> None:
    out = robot.with_name("out.urdf")
    said = _export(_with_effects(robot, RUB, BRAKE, ROTOR, GAIN), out)
    text = out.with_suffix(".yaml").read_text()
    assert "inertia" in text
    assert "effort_gain" in text
    assert "joint_friction" not in text
    assert said.count("stays in the robot file") == 2
    model = mujoco.MjModel.from_xml_path(str(out))
    assert model.joint("elbow").damping[0] == pytest.approx(0.2)


def test_an_mjcf_takes_rotors_and_keeps_what_it_had(robot: Path) -> None:
    spec = mujoco.MjSpec.from_file(str(robot.with_name("arm.urdf")))
    spec.compile()
    xml = spec.to_xml().replace('name="waist"', 'name="waist" frictionloss="0.25"', 1)
    robot.with_name("arm.xml").write_text(xml)
    file = robot.with_name("mjcf.yaml")
    chain(file, robot.with_name("arm.xml"), ",".join(JOINTS))
    out = robot.with_name("out.xml")
    _export(_with_effects(file, RUB, ROTOR), out)
    model = mujoco.MjModel.from_xml_path(str(out))
    assert model.joint("waist").frictionloss[0] == pytest.approx(0.75)
    assert model.joint("waist").armature[0] == pytest.approx(0.3)
    assert "effects" not in out.with_suffix(".yaml").read_text()


@pytest.mark.parametrize(("out", "says"), [("out.xml", "*.urdf"), ("known.urdf", "robot file")])
def test_a_wrong_name_is_refused_and_nothing_is_written(robot: Path, out: str, says: str) -> None:
    done = CliRunner().invoke(
        app, ["export", str(_with_effects(robot, RUB)), str(robot.with_name(out))]
    )
    assert done.exit_code != 0
    assert says in str(done.exception) or says in done.output
    assert not robot.with_name(out).exists()


@pytest.mark.study
def test_a_corrected_robot_file_in_another_folder_still_finds_its_model(robot: Path) -> None:
    run = recorded(robot.parent, FRICTION_NM)
    elsewhere = robot.parent / "found" / "arm.yaml"
    elsewhere.parent.mkdir()
    save_corrected(robot, diagnose([run], robot), elsewhere)
    assert diagnose([run], elsewhere).findings == []
