"""The simulators of single axes: physics that can be worked out by hand, and sizes that mean what
the vocabulary's words mean.

The generator shares no code with the models. That a size means the same in both is shown by the
models themselves: they predict the generator's readings from the hidden size alone.
"""

from __future__ import annotations

import ast
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from deltactl.models.chain.active import activate
from deltactl.models.chain.axis import AxisChain, SensorChain
from deltactl.models.chain.commands import Commands
from deltactl.proof.axis.commanded import CommandedAxis
from deltactl.proof.axis.drives import DeadBand, LuGre, PositionLoop, play, ringing, wound_up
from deltactl.proof.axis.forced import ForcedAxis
from deltactl.proof.axis.motions import ONE_WAY, STYLES, Pace, move
from deltactl.proof.axis.sensing import RangeSensor

AXIS = Path(__file__).resolve().parents[2] / "deltactl" / "proof" / "axis"
MAY_USE = ("deltactl.proof.axis", "deltactl.recording.tables", "deltactl.foundation")
STEP_S = 0.001


def foreign(source: str) -> list[str]:
    """Modules of the project that a source imports and the generator must not."""
    names: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names.append("." * node.level + (node.module or ""))
    ours = [name for name in names if name.startswith((".", "deltactl", "models", "firmware_py"))]
    return [name for name in ours if not name.startswith(MAY_USE)]


def test_the_generator_shares_no_code_with_what_it_judges() -> None:
    files = sorted(AXIS.glob("**/*.py"))
    assert len(files) > 8
    assert {file.name: foreign(file.read_text()) for file in files} == {
        file.name: [] for file in files
    }


@pytest.mark.parametrize(
    "line",
    [
        "from deltactl.models.robot_files import named_inside",
        "def late():\n    import deltactl.diagnosis.api",
        "from ...models import robot",
        "import models.signals",
    ],
)
def test_shared_code_would_be_seen(line: str) -> None:
    assert foreign(line) != []


@pytest.fixture(scope="module", name="motion")
def a_motion():
    return move("random", Pace(40.0, STEP_S, 1.0, 2.0), np.random.default_rng(5))


@pytest.mark.parametrize("style", sorted(STYLES))
def test_every_motion_stays_within_its_stroke_and_one_way_never_turns(style: str) -> None:
    moved = move(style, Pace(30.0, STEP_S, 0.5, 1.5, endless=True), np.random.default_rng(2))
    steps = np.diff(moved.position)
    if style in ONE_WAY:
        assert steps.min() >= 0.0
    else:
        assert 0.2 < np.ptp(moved.position) <= 0.5 * (1.0 + 1e-9)
        assert steps.min() < 0.0 < steps.max()
    bounded = move(style, Pace(30.0, STEP_S, 0.5, 1.5), np.random.default_rng(2))
    assert np.ptp(bounded.position) <= 0.5 * (1.0 + 1e-9)


def test_bristles_slide_with_the_force_of_coulomb_stribeck_and_speed() -> None:
    rubs = LuGre(2.0, 1.0, 0.1, 3.0, bristle=1e4, damper=10.0)
    for speed in (-0.5, -0.05, 0.05, 0.5):
        force = rubs.along(np.full(4000, speed), STEP_S, 1.0)[-1]
        dry = 2.0 + np.exp(-((speed / 0.1) ** 2))
        assert force == pytest.approx(np.sign(speed) * dry + 3.0 * speed, rel=1e-6)


def test_a_wound_up_shaft_is_behind_by_its_friction_over_its_stiffness() -> None:
    t = np.arange(0.0, 8.0, STEP_S)
    driven = np.sin(t)
    force, stiffness = 0.3, 20.0
    behind = driven - wound_up(driven, 2.0 * force / stiffness, slip=1e-3, start=0.0)
    forth, back = behind[int(1.2 / STEP_S)], behind[int(4.0 / STEP_S)]
    forth = behind[int(6.5 / STEP_S)]
    assert forth == pytest.approx(force / stiffness, rel=1e-3)
    assert back == pytest.approx(-force / stiffness, rel=1e-3)


def test_two_masses_with_a_dead_band_go_to_the_play_operator(motion) -> None:
    fastest = np.abs(np.diff(motion.position, 2)).max() / STEP_S**2
    band = DeadBand(0.02, 110.0, 0.3, 1.5 * fastest)
    two = band.follow(motion.position, STEP_S, 0.2)
    one = play(motion.position, 0.02, 0.2)
    moving = np.abs(np.gradient(motion.position, STEP_S)) > 0.2
    off = (two - one)[moving]
    assert np.sqrt(np.mean(off**2)) < 0.02 * 0.02


def test_a_position_loop_is_late_by_its_time_and_by_none_with_feed_forward() -> None:
    ramp = np.arange(0.0, 4.0, STEP_S)
    for loop, behind in (
        (PositionLoop(0.05), 0.05),
        (PositionLoop(0.05, 1.0), 0.0),
        (PositionLoop(0.05, 1.2), -0.01),
        (PositionLoop(0.05, 0.0, 0.2), 0.05),
    ):
        assert ramp[-1] - loop.follow(ramp, STEP_S)[-1] == pytest.approx(behind, abs=2e-3)
    back = PositionLoop(0.05, 0.0, 0.2).follow(-ramp, STEP_S)
    assert back[-1] + ramp[-1] == pytest.approx(0.2, abs=2e-3)
    slow = PositionLoop(1e-3, 1.0, speed_limit=0.5).follow(ramp, STEP_S)
    assert np.diff(slow).max() / STEP_S == pytest.approx(0.5)


def test_what_rings_does_so_at_its_frequency_and_dies_out_as_damped() -> None:
    step = np.where(np.arange(0.0, 3.0, STEP_S) > 0.1, 1.0, 0.0)
    rung = ringing(step, STEP_S, 4.0, 0.05) - 1.0
    after = rung[150:]
    crossings = np.flatnonzero(np.diff(np.sign(after)) > 0)
    period = np.diff(crossings).mean() * STEP_S
    assert 1.0 / period == pytest.approx(4.0 * np.sqrt(1.0 - 0.05**2), rel=0.01)
    tops = [after[a:b].max() for a, b in pairwise(crossings)]
    decay = np.log(tops[0] / tops[4]) / 4.0
    assert decay == pytest.approx(2.0 * np.pi * 0.05, rel=0.03)


COMMANDED = {
    "home_offset": {"angle": 0.02},
    "gear_ratio": {"scale": 1.03},
    "gear_backlash": {"width": 0.03},
    "joint_friction": {"width": 0.02},
    "following_lag": {"time": 0.04, "dead_time": 0.02},
    "sensor_latency": {"time": 0.03},
    "transmission_error": {"amplitude": 0.01, "period": 0.2, "phase": 0.4},
    "encoder_error": {"amplitude": 0.01, "period": 0.15, "phase": -1.0},
    "resonance": {"frequency": 2.5, "damping": 0.1},
    "lost_steps": {"steps": 40.0, "time": 20.3},
    "joint_compliance": {"stiffness": 90.0},
}


@pytest.mark.parametrize("effect", sorted(COMMANDED))
def test_the_model_with_the_hidden_size_predicts_the_axis(effect: str, motion) -> None:
    rows = np.arange(1.0, 39.0, 0.004)
    per_step = 1e-3 if effect == "lost_steps" else 0.0
    load = 2.0 * np.sign(np.sin(0.5 * motion.t_s)) if effect == "joint_compliance" else (
        np.zeros_like(motion.t_s))  # fmt: skip
    axis = CommandedAxis(motion, per_step, load, np.zeros(1), second=0.0)
    read, healthy = (axis.clean(s, rows) for s in ({effect: COMMANDED[effect]}, {}))
    chain = AxisChain(rad_per_step=per_step)
    commands = Commands.of_angles(rows, motion.at(rows)[:, None])
    pull = np.interp(rows, motion.t_s, load)[:, None]
    active = activate(chain.kinds[effect], "axis", COMMANDED[effect])
    predicted = chain.simulate(commands, [active], pull)
    signal = read - healthy
    # What bristles and masses add is no part of the size.
    rich = {"gear_backlash": 0.15, "joint_friction": 0.12}
    later = rows > 5.0
    off = (predicted - read)[later]
    assert np.std(signal[later]) > 0.0 or effect == "home_offset"
    assert np.sqrt(np.mean(off**2)) < rich.get(effect, 0.06) * np.sqrt(np.mean(signal[later] ** 2))


RANGING = {
    "sensor_offset": {"offset": 0.01},
    "sensor_scale": {"scale": 0.98},
    "sensor_crosstalk": {"curvature": 0.02},
    "sensor_drift": {"offset": 0.03, "time_constant": 12.0},
    "sensor_latency": {"time": 0.03},
}


@pytest.mark.parametrize("effect", sorted(RANGING))
def test_the_model_with_the_hidden_size_predicts_the_sensor(effect: str, motion) -> None:
    rows = np.arange(1.0, 39.0, 0.01)
    sensor = RangeSensor(motion, np.zeros_like(motion.t_s))
    chain = SensorChain()
    fresh = np.arange(len(rows)) == 0
    active = activate(chain.kinds[effect], "axis", RANGING[effect])
    predicted = chain.simulate(rows, motion.at(rows), fresh, [active])
    signal = sensor.clean({effect: RANGING[effect]}, rows) - sensor.clean({}, rows)
    off = predicted - sensor.clean({effect: RANGING[effect]}, rows)
    assert np.sqrt(np.mean(off**2)) < 0.02 * np.sqrt(np.mean(signal**2))


def balance(speed, acceleration, asked, delayed, sizes, inertia=2.0):
    """The contract's equation: force that is asked for less all that it overcomes."""
    gain = sizes.get("effort_gain", {}).get("scale", 1.0)
    mass = sizes.get("inertia", {}).get("inertia", inertia)
    force = delayed * gain - mass * acceleration
    force -= sizes.get("effort_offset", {}).get("offset", 0.0)
    force -= sizes.get("viscous_friction", {}).get("coefficient", 0.0) * speed
    dry = sizes.get("joint_friction", {}).get("torque", 0.0)
    falls = sizes.get("stribeck_friction", {"torque": 0.0, "speed": 1.0})
    dry = dry + falls["torque"] * np.exp(-((speed / falls["speed"]) ** 2))
    return force - dry * np.sign(speed)


@pytest.mark.parametrize(
    "sizes",
    [
        {"joint_friction": {"torque": 1.0}},
        {"viscous_friction": {"coefficient": 2.0}},
        {"joint_friction": {"torque": 0.5}, "stribeck_friction": {"torque": 0.8, "speed": 0.1}},
        {"effort_offset": {"offset": -0.7}},
        {"effort_gain": {"scale": 1.3}},
        {"inertia": {"inertia": 2.6}},
        {"following_lag": {"time": 0.0, "dead_time": 0.02}},
    ],
)
def test_the_recorded_effort_obeys_the_contracts_equation(sizes, motion) -> None:
    moved = ForcedAxis(motion, 2.0, bandwidth=60.0).run(sizes).moved
    assert moved is not None
    assert np.std(moved.position - motion.position) < 2e-3
    dead = sizes.get("following_lag", {}).get("dead_time", 0.0)
    late = np.interp(motion.t_s - dead, motion.t_s, moved.asked)
    left = balance(moved.speed, moved.acceleration, moved.asked, late, sizes)
    without = balance(moved.speed, moved.acceleration, moved.asked, moved.asked, {})
    moving = (np.abs(moved.speed) > 0.1) & (motion.t_s > 1.0)
    assert np.sqrt(np.mean(left[moving] ** 2)) < 0.05 * np.sqrt(np.mean(without[moving] ** 2))


def test_a_motor_at_its_limit_gives_no_more_and_falls_behind(motion) -> None:
    axis = ForcedAxis(motion, 2.0, bandwidth=60.0)
    free = axis.run({}).moved
    highest = np.abs(free.asked).max()
    held = axis.run({"effort_limit": {"limit": 0.7 * highest}}).moved
    assert np.abs(2.0 * held.acceleration).max() == pytest.approx(0.7 * highest, rel=1e-6)
    assert np.abs(held.asked).max() > 0.9 * highest
    assert (
        np.abs(held.position - motion.position).max()
        > 5.0 * np.abs(free.position - motion.position).max()
    )
