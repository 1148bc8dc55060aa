"""Logs of whole arms, named as their makers' programs name them: `inspect` prints what describes
the arm by its URDF and diagnoses all joints together, and that runs as printed.
"""

from __future__ import annotations

import json
import shlex
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.one_screen import LINES
from deltactl.models.rigid_chain import RigidChain
from deltactl.recording.foreign.arms import as_arm, fitted_to, joint_names
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import each_joint, joints_together, load_mapping
from tests.inspection.test_printed_commands import printed
from tests.inspection.test_shown import in_a_window
from tests.rigs import needs

pytest.importorskip("mujoco")

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
Array = np.ndarray
JOINTS = ("base", "shoulder", "elbow", "wrist", "flange")
AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0")
RUBS = "elbow"
NM_PER_UNIT = 5.0
COUNTS = 4096 / (2.0 * np.pi)


def urdf() -> str:
    """An arm of five joints."""
    parts = ['<robot name="five"><link name="below"/>']
    for n, (name, axis) in enumerate(zip(JOINTS, AXES, strict=True)):
        above = f"link_{JOINTS[n - 1]}" if n else "below"
        mass = 4.0 - 0.7 * n
        inertia = " ".join(f'i{a}{a}="{0.01 * mass}"' for a in "xyz")
        parts.append(
            f'<joint name="{name}" type="revolute"><parent link="{above}"/>'
            f'<child link="link_{name}"/><origin xyz="0.03 0.02 0.2"/><axis xyz="{axis}"/>'
            '<limit lower="-3" upper="3" effort="99" velocity="9"/></joint>'
            f'<link name="link_{name}"><inertial><origin xyz="0.04 0.01 0.08"/>'
            f'<mass value="{mass}"/><inertia {inertia} ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    return "".join([*parts, "</robot>"])


def moved(folder: Path) -> tuple[Array, Array, Array, Array]:
    """Times, angles, velocities and efforts (n, 5) of the arm, whose elbow rubs."""
    rng = np.random.default_rng(3)
    t_s = np.arange(0.0, 25.0, 0.01)
    angle = np.zeros((len(t_s), len(JOINTS)))
    for joint in angle.T:
        for k in (1, 2, 3, 4):
            size, phase = rng.uniform(0.4, 0.8) / k, rng.uniform(0.0, 6.0)
            joint += size * np.sin(2.0 * np.pi * 0.1 * k * t_s + phase)
    speed = np.gradient(angle, t_s, axis=0)
    (folder / "arm.urdf").write_text(urdf())
    arm = RigidChain(folder / "arm.urdf", JOINTS)
    effort = arm.efforts(angle, speed, np.gradient(speed, t_s, axis=0))
    effort[:, JOINTS.index(RUBS)] += 2.0 * np.sign(speed[:, JOINTS.index(RUBS)])
    effort += 0.02 * np.std(effort, axis=0) * rng.standard_normal(effort.shape)
    return t_s, angle + 2e-5 * rng.standard_normal(angle.shape), speed, effort


def numbered(*stems: str, first: int = 0) -> list[str]:
    return [stem.format(n) for stem in stems for n in range(first, first + len(JOINTS))]


def by_name(*stems: str, names: Sequence[str]) -> list[str]:
    return [stem.format(name) for stem in stems for name in names]


def ur(t: Array, q: Array, dq: Array, effort: Array) -> tuple[list[str], list[Array]]:
    stems = ("target_q_{}", "actual_q_{}", "actual_qd_{}", "actual_current_{}", "target_moment_{}")
    names = numbered(*stems, "actual_TCP_pose_{}")
    return ["timestamp", *names], [t, q, q, dq, effort / NM_PER_UNIT, effort, 0.2 * q]


def franka(t: Array, q: Array, dq: Array, effort: Array) -> tuple[list[str], list[Array]]:
    stems = ("q[{}]", "q_d[{}]", "dq[{}]", "tau_J[{}]", "tau_ext_hat_filtered[{}]")
    return ["time", *numbered(*stems)], [t, q, q, dq, effort, 0.1 * effort]


def dynamixel(t: Array, q: Array, dq: Array, effort: Array) -> tuple[list[str], list[Array]]:
    read = np.round(2048 + COUNTS * q)
    names = numbered("goal_position_{}", "present_position_{}", "present_current_{}", first=11)
    return ["time", *names], [t, read, read, np.round(200.0 * effort)]


def joint_states(t: Array, q: Array, dq: Array, effort: Array) -> tuple[list[str], list[Array]]:
    """As PlotJuggler writes them, in the order of the alphabet."""
    names = sorted(JOINTS)
    order = [JOINTS.index(name) for name in names]
    stems = ("/joint_states/{}/position", "/joint_states/{}/velocity", "/joint_states/{}/effort")
    head = ["__time", *by_name(*stems, names=names)]
    return head, [t, q[:, order], dq[:, order], effort[:, order]]


def lerobot(t: Array, q: Array, dq: Array, effort: Array) -> tuple[list[str], list[Array]]:
    stems = ("action.{}.pos", "observation.state.{}.pos", "observation.state.{}.current")
    head = ["timestamp", *by_name(*stems, names=JOINTS)]
    return head, [t, np.degrees(q), np.degrees(q), effort / NM_PER_UNIT]


MADE_BY = {
    ur: ("ur.csv", "actual_q_2", NM_PER_UNIT),
    franka: ("franka.csv", "q[2]", None),
    dynamixel: ("dynamixel.csv", "present_position_13", 1.0 / 200.0),
    joint_states: ("states.csv", "/joint_states/elbow/position", None),
    lerobot: ("lerobot.csv", "observation.state.elbow.pos", NM_PER_UNIT),
}
Maker = Callable[[Array, Array, Array, Array], tuple[list[str], list[Array]]]


def write(folder: Path, maker: Maker) -> Path:
    head, parts = maker(*moved(folder))
    file = folder / MADE_BY[maker][0]
    np.savetxt(file, np.column_stack(parts), "%.8g", ",", header=",".join(head), comments="")
    return file


@pytest.mark.study
@pytest.mark.parametrize("maker", MADE_BY)
def test_what_inspect_prints_of_an_arm_runs(
    deltactl: Deltactl, tmp_path: Path, maker: Maker
) -> None:
    file, column, gain = MADE_BY[maker]
    write(tmp_path, maker)
    shown = deltactl("inspect", file)
    words = {"MODEL.urdf": "arm.urdf", "GAIN": str(gain)}
    init = [words.get(word, word) for word in printed(shown, "describe the machine:")]
    assert ("--effort-gain" in init) == (gain is not None)
    assert deltactl(*init).returncode == 0
    command = printed(shown)
    angles = [word for word in command if word.startswith("theta=")]
    sources = {one.from_ for one in load_mapping(None, angles).columns.values()}
    assert column in sources
    assert len(sources) == len(JOINTS)
    found = json.loads(deltactl(*command, "--json", "-").stdout)["findings"]
    assert [(one["effect"], one["component"]) for one in found] == [("joint_friction", RUBS)]
    bare = deltactl(*command[:4], "--json", "-")
    assert json.loads(bare.stdout)["findings"] == found
    assert f"{file}: is read as inspected" in bare.stderr


def write_mcap(folder: Path) -> Path:
    """Joint states as ROS 2 logs them, with a gripper among the joints."""
    writers = pytest.importorskip("mcap_ros2.writer", reason=needs.LOGS)
    from tests.inspection.test_inspect_logs import JOINT_STATE, START_NS, stamp

    names = ["gripper", *JOINTS]
    file = folder / "run.mcap"
    with file.open("wb") as stream, writers.Writer(stream) as writer:
        state = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for t_s, *row in zip(*moved(folder), strict=True):
            lists = {
                key: [0.01, *map(float, values)]
                for key, values in zip(("position", "velocity", "effort"), row, strict=True)
            }
            message = {"header": {"stamp": stamp(t_s), "frame_id": ""}, "name": names, **lists}
            at = START_NS + round(t_s * 1e9)
            writer.write_message("/joint_states", state, message, at, at)
    return file


@pytest.mark.study
def test_joint_states_of_an_mcap_file_are_those_of_the_model(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    file = write_mcap(tmp_path).name
    shown = deltactl("inspect", file)
    init = [
        word.replace("MODEL.urdf", "arm.urdf") for word in printed(shown, "describe the machine:")
    ]
    joints = init.index("--joints") + 1
    assert init[joints] == ",".join(["gripper", *JOINTS])
    assert "a gripper" in shown.stdout
    init[joints] = init[joints].removeprefix("gripper,")
    assert deltactl(*init).returncode == 0
    command = [word.replace("{gripper,", "{") for word in printed(shown)]
    for words in (command, command[:4]):
        found = json.loads(deltactl(*words, "--json", "-").stdout)["findings"]
        assert [(one["effect"], one["component"]) for one in found] == [("joint_friction", RUBS)]


def test_one_joint_by_itself_is_offered_and_runs(deltactl: Deltactl, tmp_path: Path) -> None:
    write(tmp_path, ur)
    label = "  without a model, one joint:"
    alone = printed(deltactl("inspect", "ur.csv"), label)
    assert alone[:4] == ["inspect", "ur.csv", "--set", "position=actual_q_0"]
    shown = deltactl(*alone)
    words = printed(shown, "describe the machine:") + printed(shown)
    assert "MOTION" not in words
    assert "unit=UNIT" not in words


def test_the_joint_that_is_offered_departs_most_from_its_command(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    file = write(tmp_path, ur)
    head = file.read_text().partition("\n")[0]
    columns = np.loadtxt(file, delimiter=",", skiprows=1)
    columns[:, head.split(",").index("actual_q_3")] *= 1.05
    np.savetxt(file, columns, "%.8g", ",", header=head, comments="")
    alone = printed(deltactl("inspect", file.name), "  without a model, one joint:")
    assert "position=actual_q_3" in alone


@pytest.mark.study
def test_an_arm_is_shown_on_one_screen(tmp_path: Path) -> None:
    write(tmp_path, ur)
    shown = in_a_window(tmp_path, 80, "inspect", "ur.csv")
    assert max(map(len, shown.splitlines())) <= 80
    command = shlex.split(shown[shown.index("deltactl diagnose") :])
    assert {"theta=actual_q_{0..4}", "effort=actual_current_{0..4}"} <= {*command}
    assert len(shown.splitlines()) <= LINES


def test_joints_are_found_by_name_and_counted(tmp_path: Path) -> None:
    arm = as_arm(inspect(write(tmp_path, joint_states)))
    assert arm is not None
    assert joint_names(arm) == sorted(JOINTS)
    fitted, why_not = fitted_to(arm, JOINTS[1:])
    angles = {one.name: one.source for one in fitted.guesses.values() if one.role == "theta"}
    assert not why_not
    assert angles["theta_1"] == "/joint_states/shoulder/position"
    assert fitted.mapping.columns["theta_1"].from_ == angles["theta_1"]
    assert len(angles) == len(JOINTS) - 1
    assert "joint tool" in fitted_to(arm, [*JOINTS, "tool"])[1]
    unnamed = as_arm(inspect(write(tmp_path, ur)))
    assert unnamed is not None
    assert joint_names(unnamed) == []
    assert "5 joints, and the robot file has 4" in fitted_to(unnamed, JOINTS[1:])[1]


def test_counts_of_a_joint_with_a_drive_stay_counts(tmp_path: Path) -> None:
    """The robot file says what one is; the usual 4096 a turn are then no guess to make."""
    arm = as_arm(inspect(write(tmp_path, dynamixel)))
    assert arm is not None
    usual, _ = fitted_to(arm, JOINTS)
    fitted, _ = fitted_to(arm, JOINTS, [1e-3] * len(JOINTS))
    assert usual.mapping.columns["theta_1"].scale != 1.0
    assert fitted.mapping.columns["theta_1"].scale == 1.0
    assert any("4096" in one for one in usual.warnings)
    assert not any("4096" in one for one in fitted.warnings)


@pytest.mark.parametrize("heads", [("{}_theta", "effort_{}"), ("theta_{}", "{}_effort")])
def test_columns_of_the_contract_are_called_by_joints(
    deltactl: Deltactl, tmp_path: Path, heads: tuple[str, str]
) -> None:
    t_s, angle, _, effort = moved(tmp_path)
    head = ",".join(["t", *by_name(*heads, names=JOINTS)])
    file = tmp_path / "own.csv"
    np.savetxt(file, np.column_stack([t_s, angle, effort]), "%.8g", ",", header=head, comments="")
    init = printed(deltactl("inspect", "own.csv"), "describe the machine:")
    assert init[-2:] == ["--joints", ",".join(JOINTS)]


def test_columns_of_the_contract_need_no_option(deltactl: Deltactl, tmp_path: Path) -> None:
    t_s, angle, _, effort = moved(tmp_path)
    head = ",".join(["t", *numbered("theta_{}", "effort_{}", first=1)])
    file = tmp_path / "own.csv"
    np.savetxt(file, np.column_stack([t_s, angle, effort]), "%.8g", ",", header=head, comments="")
    command = printed(deltactl("inspect", "own.csv"))
    assert command[:3] == ["diagnose", "own.csv", "--robot"]
    assert len(command) == 4


@pytest.mark.parametrize("number", [1, 2, 3])
def test_no_arm_has_as_few_joints_as_a_delta(tmp_path: Path, number: int) -> None:
    names = [f"{what}_{n}" for what in ("actual_q", "actual_current") for n in range(number)]
    t_s = np.arange(0.0, 10.0, 0.01)
    parts = [np.sin((1.0 + 0.1 * n) * t_s) for n in range(len(names))]
    file = tmp_path / "few.csv"
    head = ",".join(["timestamp", *names])
    np.savetxt(file, np.column_stack([t_s, *parts]), "%.6g", ",", header=head, comments="")
    assert as_arm(inspect(file)) is None


@pytest.mark.parametrize(
    "columns",
    [
        ["q_0", "q_1", "q_2"],
        ["q[8]", "q[9]", "q[10]"],
        ["a.pos[deg]", "b.pos[deg]"],
        ["p_1*0.5-3", "p_2*0.5-3"],
        ["wrist_1", "wrist_3", "elbow"],
        ["one", "one"],
        ["q_01"],
        ["q_1", "q_0"],
        ["a,b", "c"],
    ],
)
def test_options_of_joints_are_one_with_braces(columns: list[str]) -> None:
    options = [f"theta_{n}={column}" for n, column in enumerate(columns, 1)]
    together = joints_together(["t=time", *options])
    assert [one for short in together for one in each_joint(short)] == ["t=time", *options]
    assert load_mapping(None, together) == load_mapping(None, ["t=time", *options])
