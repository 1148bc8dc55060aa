"""An arm that a URDF describes: hidden friction and load are found, and nothing where nothing is.

The simulated arm shares no code with the models: its efforts are by the recursive Newton-Euler
equations (Luh, Walker and Paul 1980), written here, with points for links and load.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.cli.recordings.init_chain import chain
from deltactl.cli.recordings.tables import read_plain
from deltactl.diagnosis.api import diagnose
from deltactl.diagnosis.report.next_run import experiment_line
from deltactl.foundation.errors import DeltactlError
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot_files import load_with_effects
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.chain_tables import joints_of
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat

pytest.importorskip("mujoco")

AXES = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
ORIGINS = np.array([[0.0, 0.0, 0.2], [0.0, 0.05, 0.1], [0.4, 0.0, 0.0]])
CENTRES = np.array([[0.0, 0.02, 0.05], [0.2, 0.0, 0.0], [0.15, 0.0, 0.02]])
MASSES = np.array([4.0, 3.0, 2.0])
INERTIAS = np.array([[0.02, 0.02, 0.01], [0.005, 0.04, 0.04], [0.003, 0.02, 0.02]])
JOINTS = ("waist", "shoulder", "elbow")
LOAD_KG, LOAD_AT = 0.8, np.array([0.25, 0.03, 0.0])
FRICTION_NM = 1.5
Fault = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def urdf_text(without: str = "") -> str:
    parts = ['<robot name="three"><link name="base"/>']
    for j, name in enumerate(JOINTS):
        parent = "base" if j == 0 else f"body_{JOINTS[j - 1]}"
        vectors = [" ".join(map(str, row[j])) for row in (ORIGINS, AXES, CENTRES)]
        xx, yy, zz = INERTIAS[j]
        inertial = (
            f'<inertial><origin xyz="{vectors[2]}"/><mass value="{MASSES[j]}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>'
        )
        mesh = '<visual><geometry><mesh filename="package://gone/a.stl"/></geometry></visual>'
        parts.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="body_{name}"/><origin xyz="{vectors[0]}"/><axis xyz="{vectors[1]}"/>'
            f'<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>'
            f'<link name="body_{name}">{mesh}{"" if name == without else inertial}</link>'
        )
    return "".join([*parts, "</robot>"])


def _turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    sine, rest = np.sin(angle)[:, None, None], 1.0 - np.cos(angle)[:, None, None]
    return np.eye(3) + sine * cross + rest * (cross @ cross)


def efforts(q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, load_kg: float) -> np.ndarray:
    """Torques (n, 3) of a motion."""
    n = len(q)
    frame, spin, swing = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)), np.zeros((n, 3))
    pull, place = np.tile([0.0, 0.0, 9.81], (n, 1)), np.zeros((n, 3))
    axes, places, bodies = [], [], []
    for j in range(3):
        arm = frame @ ORIGINS[j]
        pull = pull + np.cross(swing, arm) + np.cross(spin, np.cross(spin, arm))
        place = place + arm
        axis = frame @ AXES[j]
        swing = swing + axis * ddq[:, j, None] + np.cross(spin, axis * dq[:, j, None])
        spin = spin + axis * dq[:, j, None]
        frame = frame @ _turn(AXES[j], q[:, j])
        points = [(MASSES[j], CENTRES[j], np.diag(INERTIAS[j]))]
        points += [(load_kg, LOAD_AT, np.zeros((3, 3)))] if j == 2 else []
        axes.append(axis)
        places.append(place)
        for mass, centre, own in points:
            off = frame @ centre
            force = mass * (pull + np.cross(swing, off) + np.cross(spin, np.cross(spin, off)))
            turned = frame @ own @ np.swapaxes(frame, 1, 2)
            momentum = np.einsum("nij,nj->ni", turned, spin)
            moment = np.einsum("nij,nj->ni", turned, swing) + np.cross(spin, momentum)
            bodies.append((j, place + off, force, moment))
    torque = np.zeros((n, 3))
    for j, at, force, moment in bodies:
        for i in range(j + 1):
            whole = moment + np.cross(at - places[i], force)
            torque[:, i] += np.sum(axes[i] * whole, axis=1)
    return torque


def recorded(
    folder: Path,
    friction_nm: float = 0.0,
    load_kg: float = 0.0,
    names: str = "theta_{n}",
    fault: Fault | None = None,
    seconds: float = 25.0,
    moving: Sequence[int] = (0, 1, 2),
) -> Path:
    """A table at 100 Hz of Fourier series, with noise of encoders and currents.

    moving: joints that move. fault: what it makes of times, positions, velocities and efforts
    (n, 3) is the effort recorded.
    """
    rng = np.random.default_rng(7)
    t_s = np.arange(0.0, seconds, 0.01)
    q, dq, ddq = (np.zeros((len(t_s), 3)) for _ in range(3))
    for j in range(3):
        for harmonic in (1, 2, 3, 4):
            w = 2.0 * np.pi * 0.12 * harmonic
            size, phase = 0.8 / harmonic * rng.uniform(0.5, 1.0), rng.uniform(0.0, 2.0 * np.pi)
            q[:, j] += size * np.sin(w * t_s + phase)
            dq[:, j] += size * w * np.cos(w * t_s + phase)
            ddq[:, j] -= size * w * w * np.sin(w * t_s + phase)
    still = [j for j in range(3) if j not in moving]
    q[:, still] = dq[:, still] = ddq[:, still] = 0.0
    effort = efforts(q, dq, ddq, load_kg)
    effort[:, 1] += friction_nm * np.sign(dq[:, 1])
    effort = effort if fault is None else fault(t_s, q, dq, effort)
    effort += 0.05 * rng.standard_normal(effort.shape)
    q += 2e-5 * rng.standard_normal(q.shape)
    head = [names.format(n=n, joint=joint) for n, joint in enumerate(JOINTS, 1)]
    head += [f"effort_{n}" for n in (1, 2, 3)]
    table = folder / "run.csv"
    rows = np.column_stack([t_s, q, effort])
    np.savetxt(table, rows, "%.8g", ",", header=",".join(["t", *head]), comments="")
    return table


def test_hidden_friction_and_load_are_found_with_their_sizes(robot: Path) -> None:
    answer = diagnose([recorded(robot.parent, FRICTION_NM, LOAD_KG)], robot)
    found = {(one.effect, one.component): one for one in answer.findings}
    assert set(found) == {("joint_friction", "shoulder"), ("payload", "body_elbow")}
    friction = found["joint_friction", "shoulder"].parameters["torque"].components[0]
    assert friction[1] <= FRICTION_NM <= friction[2]
    load = found["payload", "body_elbow"].parameters
    mass = load["mass"].components[0]
    assert mass[1] <= LOAD_KG <= mass[2]
    assert mass[0] == pytest.approx(LOAD_KG, rel=0.1)
    assert load["centre_x"].components[0][0] == pytest.approx(LOAD_AT[0], abs=0.02)
    assert answer.fit.rms_after_m < 0.2 * answer.fit.rms_before_m


def test_nothing_is_found_where_nothing_is_hidden(robot: Path) -> None:
    """Paths may be text, and columns be called by the joints."""
    named = recorded(robot.parent, names="theta_{joint}")
    head, rest = named.read_text().split("\n", 1)
    named.write_text(f"{head},position\n" + "\n".join(f"{row},0" for row in rest.splitlines()))
    answer = diagnose([str(named)], str(robot))
    assert answer.findings == []
    assert answer.verdict == "nothing_missing"
    assert answer.doubts == []


@pytest.mark.study
def test_what_the_robot_file_states_is_no_finding(robot: Path) -> None:
    stated = {"effect": "joint_friction", "component": "shoulder"}
    entry: dict[str, Any] = {**stated, "parameters": {"torque": FRICTION_NM}}
    robot.write_text(f"{robot.read_text()}effects: [{entry}]\n")
    answer = diagnose([recorded(robot.parent, FRICTION_NM)], robot)
    assert answer.findings == []


MADE_BY_ONE = np.array([0.5, 0.25, 2.0])


def _in_units(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    return effort / MADE_BY_ONE


def test_gains_that_nobody_knows_are_measured_beside_friction(tmp_path: Path) -> None:
    model, robot = tmp_path / "arm.urdf", tmp_path / "unknown.yaml"
    model.write_text(urdf_text())
    chain(robot, model, effort_gain="unknown")
    answer = diagnose([recorded(tmp_path, FRICTION_NM, fault=_in_units)], robot)
    (friction,) = answer.findings
    assert (friction.effect, friction.component) == ("joint_friction", "shoulder")
    assert friction.parameters["torque"].value == pytest.approx(FRICTION_NM, rel=0.01)
    (doubt,) = answer.doubts
    said = [float(one) for one in doubt.partition("[")[2].partition("]")[0].split(",")]
    np.testing.assert_allclose(said, MADE_BY_ONE, rtol=0.01)


def _late(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    asked = np.interp(t_s + 0.025, t_s, effort[:, 1])
    return np.column_stack([effort[:, 0], asked, effort[:, 2]])


def _sluggish(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    asked = effort[:, 1] + 0.04 * np.gradient(effort[:, 1], t_s)
    return np.column_stack([effort[:, 0], asked, effort[:, 2]])


def _weak(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    return effort / np.array([1.0, 0.88, 1.0])


@pytest.mark.study
@pytest.mark.parametrize(
    ("fault", "effect", "parameter", "size"),
    [
        (_late, "following_lag", "dead_time", 0.025),
        (_sluggish, "following_lag", "time", 0.04),
        (_weak, "effort_gain", "scale", 0.88),
    ],
)
def test_what_any_drive_has_a_little_of_is_named_where_it_is_large(
    robot: Path, fault: Fault, effect: str, parameter: str, size: float
) -> None:
    (found,) = diagnose([recorded(robot.parent, fault=fault)], robot).findings
    assert (found.effect, found.component) == (effect, "shoulder")
    value, low, high = found.parameters[parameter].components[0]
    assert low <= size <= high
    assert value == pytest.approx(size, rel=0.1)
    assert set(found.parameters) == {parameter}


def _strong(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    return effort * np.array([1.0, 1.03, 1.0])


@pytest.mark.study
def test_an_interval_allows_for_a_torque_constant_within_its_tolerance(robot: Path) -> None:
    (found,) = diagnose([recorded(robot.parent, FRICTION_NM, fault=_strong)], robot).findings
    assert (found.effect, found.component) == ("joint_friction", "shoulder")
    _, low, high = found.parameters["torque"].components[0]
    assert low <= FRICTION_NM <= high


def _rubs_one_way(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    rubs = np.where(dq[:, [1]] > 0.0, 2.0, -1.0)
    return effort + rubs * np.array([0.0, 1.0, 0.0])


@pytest.mark.study
def test_friction_that_is_stronger_one_way_may_be_a_constant_effort(robot: Path) -> None:
    answer = diagnose([recorded(robot.parent, fault=_rubs_one_way)], robot)
    found = {one.effect: one for one in answer.findings}
    assert set(found) == {"joint_friction", "effort_offset"}
    assert found["joint_friction"].parameters["torque"].value == pytest.approx(1.5, rel=0.1)
    assert found["effort_offset"].parameters["offset"].value == pytest.approx(0.5, rel=0.2)
    others = found["effort_offset"].alternatives
    assert [(one.effect, one.component) for one in others] == [("joint_friction", "shoulder")]


@pytest.mark.study
def test_a_drive_that_is_late_is_no_finding_once_its_robot_file_says_so(robot: Path) -> None:
    entry = {"effect": "following_lag", "component": "shoulder"}
    late: dict[str, Any] = {**entry, "parameters": {"dead_time": 0.025}}
    robot.write_text(f"{robot.read_text()}effects: [{late}]\n")
    assert diagnose([recorded(robot.parent, fault=_late)], robot).findings == []


def _drifts(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
    return effort * np.stack([np.ones(len(t_s)), 1.0 + 0.3 * t_s / t_s[-1], np.ones(len(t_s))], 1)


def _shares_a_motor(
    t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray
) -> np.ndarray:
    return effort + 0.1 * effort[:, [1]] * np.array([1.0, 0.0, 0.0])


def _rubs_at_one_end(
    t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray
) -> np.ndarray:
    rubs = (1.0 + q[:, [0]]) * np.sign(dq[:, [0]])
    return effort + rubs * np.array([1.0, 0.0, 0.0])


@pytest.mark.study
@pytest.mark.parametrize(
    ("fault", "joint"),
    [(_drifts, "shoulder"), (_shares_a_motor, "waist"), (_rubs_at_one_end, "waist")],
)
def test_what_no_effect_does_is_unknown_at_its_joint(robot: Path, fault: Fault, joint: str) -> None:
    answer = diagnose([recorded(robot.parent, fault=fault, seconds=80.0)], robot)
    assert ("unknown", joint) in {(one.effect, one.component) for one in answer.findings}
    assert {one.component for one in answer.findings} == {joint}


@pytest.mark.study
@pytest.mark.parametrize(("way", "damping", "by_load"), [(2e-3, 0.0, 0.0), (5e-4, 2.0, 0.1)])
def test_a_bearing_that_yields_before_it_slides_has_the_friction_of_its_model(
    robot: Path, way: float, damping: float, by_load: float
) -> None:
    """Friction that grows with the load of the gear, which the damping is not, yields as well."""
    model = robot.with_name("arm.urdf")
    stated = f'<dynamics friction="{FRICTION_NM}" damping="{damping}"/>'
    model.write_text(model.read_text().replace("</joint>", f"{stated}</joint>"))

    def yields(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
        held, made = np.zeros(3), np.empty_like(q)
        for row, move in enumerate(np.diff(q, axis=0, prepend=q[:1]) / way):
            made[row] = held = np.clip(held + move, -1.0, 1.0)
        load = np.abs(effort)
        grips = FRICTION_NM + np.minimum(by_load, 0.6 * FRICTION_NM / load.mean(0)) * (
            load - load.mean(0)
        )
        return effort + damping * dq + grips * made

    assert diagnose([recorded(robot.parent, fault=yields)], robot).findings == []


@pytest.mark.study
def test_a_joint_is_known_by_its_own_noise_and_not_by_that_of_a_larger_one(robot: Path) -> None:
    def rubs(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
        noise = 6.0 * np.random.default_rng(1).standard_normal(len(t_s))
        return effort + np.column_stack([0.0 * t_s, noise, 0.02 * np.sign(dq[:, 2])])

    (found,) = diagnose([recorded(robot.parent, fault=rubs, seconds=60.0)], robot).findings
    assert (found.effect, found.component) == ("joint_friction", "elbow")
    _, low, high = found.parameters["torque"].components[0]
    assert low <= 0.02 <= high


@pytest.mark.study
def test_places_beside_efforts_are_said_to_be_unused(robot: Path) -> None:
    made = recorded(robot.parent)
    head, *rows = made.read_text().splitlines()
    made.write_text("\n".join([f"{head},pos_x,pos_y,pos_z", *(f"{row},0.1,0,0" for row in rows)]))
    (doubt,) = diagnose([made], robot).doubts
    assert "pos_x" in doubt


@pytest.mark.study
def test_what_one_joint_alone_leaves_tied_is_told_apart_by_the_motion_proposed(robot: Path) -> None:
    def heavier(t_s: np.ndarray, q: np.ndarray, dq: np.ndarray, effort: np.ndarray) -> np.ndarray:
        change = np.gradient(dq[:, 0], t_s)
        return effort + np.column_stack([0.3 * change, 0.0 * t_s, 0.0 * t_s])

    answer = diagnose([recorded(robot.parent, fault=heavier, moving=[0])], robot)
    (found,) = answer.findings
    tied = {(found.effect, found.component), *((a.effect, a.component) for a in found.alternatives)}
    assert {("inertia", "waist"), ("payload", "body_elbow")} <= tied
    run = answer.next_experiment
    assert run is not None
    assert {"inertia waist", "payload body_elbow"} <= set(run.tells_apart)
    assert run.job["path"]["shape"] == "fourier"
    assert "init chain --motion" in experiment_line(answer)
    still = {one.component for one in answer.not_testable}
    assert still == {"shoulder", "elbow"}


def _refused(robot: Path, recording: Path) -> str:
    with pytest.raises(DeltactlError) as caught:
        diagnose([recording], robot)
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_columns_are_found_by_joint_names_and_by_what_is_set(robot: Path) -> None:
    """Joint by joint, as logs of arms name them."""
    own = recorded(robot.parent)
    rows = own.read_text().split("\n", 1)[1]
    stems = ("theta", "effort")
    columns = [f"{stem}_{joint}" for stem in stems for joint in JOINTS]
    by_joint, by_log = own.with_name("joints.csv"), own.with_name("log.csv")
    by_joint.write_text("\n".join([",".join(["t", *columns]), rows]))
    logged = [f"actual_{stem}_{n}" for stem in ("q", "current") for n in range(3)]
    by_log.write_text("\n".join([",".join(["timestamp", *logged]), rows]))
    said = [f"{s}_{n}" for s in stems for n in (1, 2, 3)]
    options = [f"{name}={column}" for name, column in zip(said, logged, strict=True)]
    mapping = load_mapping(None, ["t=timestamp", *options])
    chain_of = load_with_effects(robot)
    plain = joint_columns(read_flat(own))
    assert np.array_equal(joint_columns(read_plain(by_joint, chain_of)), plain)
    assert np.array_equal(joint_columns(read_mapped(by_log, mapping)), plain)


def joint_columns(recording: FlatRecording) -> np.ndarray:
    """Angles and efforts (n, 6)."""
    found = [joints_of(JOINTS, recording, stem) for stem in ("theta", "effort")]
    return np.concatenate([one for one in found if one is not None], axis=1)


def test_an_unknown_joint_is_refused_with_the_nearest_name(robot: Path) -> None:
    robot.write_text(robot.read_text().replace("shoulder", "sholder"))
    assert "'shoulder'" in _refused(robot, recorded(robot.parent))


def test_a_link_without_mass_is_refused_by_name(robot: Path) -> None:
    robot.with_name("arm.urdf").write_text(urdf_text(without="elbow"))
    says = _refused(robot, recorded(robot.parent))
    assert "body_elbow" in says
    assert "<inertial>" in says


def test_a_loop_is_refused(robot: Path) -> None:
    ends = '<parent link="base"/><child link="body_elbow"/>'
    loop = f'<joint name="rod" type="revolute">{ends}</joint>'
    robot.with_name("arm.urdf").write_text(urdf_text().replace("</robot>", f"{loop}</robot>"))
    assert "'rod'" in _refused(robot, recorded(robot.parent))


def test_a_missing_column_is_refused_by_joint(robot: Path) -> None:
    table = recorded(robot.parent)
    table.write_text(table.read_text().replace("effort_2", "current_b", 1))
    says = _refused(robot, table)
    assert "effort_2" in says
    assert "'shoulder'" in says


def test_degrees_are_refused(robot: Path) -> None:
    table = recorded(robot.parent)
    head, *rows = table.read_text().splitlines()
    cells = np.loadtxt(rows, delimiter=",")
    cells[:, 1:4] = np.rad2deg(cells[:, 1:4])
    np.savetxt(table, cells, "%.8g", ",", header=head, comments="")
    assert "deg" in _refused(robot, table)


def test_init_refuses_what_is_no_model(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text("<html/>")
    out = tmp_path / "arm.yaml"
    with pytest.raises(DeltactlError, match="neither a URDF"):
        chain(out, tmp_path / "arm.urdf")
    assert not out.exists()


def test_a_gantry_of_an_mjcf_without_its_meshes_weighs_what_it_says(tmp_path: Path) -> None:
    mesh = '<geom type="mesh" mesh="gone"/>'
    (tmp_path / "gantry.xml").write_text(
        '<mujoco><asset><mesh name="gone" file="gone.stl"/></asset><worldbody><body name="beam">'
        '<joint name="along" type="slide" axis="1 0 0" damping="2"/>'
        f'<inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>{mesh}<body name="head">'
        '<joint name="up" type="slide" axis="0 0 1"/>'
        f'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{mesh}</body></body></worldbody>'
        "</mujoco>"
    )
    gantry = RigidChain(tmp_path / "gantry.xml", ("along", "up"))
    speed, change = np.array([[0.5, 0.1]]), np.array([[0.2, -0.3]])
    needed = gantry.efforts(np.zeros((1, 2)), speed, change)
    assert needed == pytest.approx(np.array([[4.0 * 0.2 + 2.0 * 0.5, 1.0 * (9.81 - 0.3)]]))
    floating = RigidChain(tmp_path / "gantry.xml", ("along", "up"), gravity=False)
    assert floating.efforts(np.zeros((1, 2)), speed, change)[0, 1] == pytest.approx(-0.3)
