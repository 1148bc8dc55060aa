"""Everything that is refused before anything moves, with the first bad point named."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.paths.shapes import point_target_count
from deltactl.firmware_py.planner.plan import make_plan
from deltactl.foundation.errors import LimitExceeded, UnreachablePoint
from deltactl.models.inverse_kinematics import GeometricInverse
from deltactl.models.linkage import Linkage, Status, inverse

GEOMETRY = {"kind": "geometry"}


def line_to(x_m: float, spacing_m: float = 0.01) -> dict:
    ends = [[0, 0, -0.45], [x_m, 0, -0.45]]
    return {"shape": "points", "points_m": ends, "spacing_m": spacing_m}


def plan(job, robot, kinematics=None):
    return make_plan(job, robot, kinematics or GeometricInverse(robot.geometry))


def refusal(job, robot, kinematics=None) -> str:
    with pytest.raises((LimitExceeded, UnreachablePoint)) as error:
        plan(job, robot, kinematics)
    message = str(error.value)
    assert "\n" not in message
    assert message.startswith(job.name)
    return message


@settings(max_examples=40, deadline=None)
@given(angle=st.floats(-np.pi, np.pi), spacing_m=st.floats(0.002, 0.02))
def test_the_first_point_out_of_the_workspace_is_named(zhao, job_of, angle, spacing_m):
    out = [0.6 * np.cos(angle), 0.6 * np.sin(angle), -0.45]
    path = {"shape": "points", "points_m": [[0, 0, -0.45], out], "spacing_m": spacing_m}
    job = job_of(path=path)
    message = refusal(job, zhao)
    named = int(message.split("point ")[1].split()[0])
    count = point_target_count(path["points_m"], spacing_m) - 1
    at = np.array([0, 0, -0.45]) + (named / count) * (np.array(out) - [0, 0, -0.45])
    before = at - (np.array(out) - [0, 0, -0.45]) / count
    seen = inverse(Linkage.of(zhao.geometry), np.stack([before, at]))
    fine = (np.rad2deg(seen.angles_rad) <= 110.1) & (np.rad2deg(seen.angles_rad) >= -20.1)
    assert seen.status[0] == Status.OK
    assert fine[0].all()
    text = f"({at[0]:.4f}, {at[1]:.4f}, {at[2]:.4f}) m"
    assert text in message
    assert "repeat" not in message


def test_out_of_reach(zhao, job_of, limited):
    robot = limited(arm_deg=(-180.0, 180.0), singularity_margin=0.0)
    message = refusal(job_of(path=line_to(0.9)), robot)
    assert "out of reach" in message
    assert "point" in message


def test_an_arm_limit_names_arm_angle_and_point(zhao, job_of, limited):
    message = refusal(job_of(path=line_to(0.25)), limited(arm_deg=(0.0, 80.0)))
    assert "point 24 at (0.2400, 0.0000, -0.4500) m" in message
    assert "arm 2 would be at 81.48 deg" in message
    assert "outside its limits of 0 to 80 deg (limits.arm_deg" in message


def test_the_box_is_kept(zhao, job_of, limited):
    robot = limited(box_m=((-0.1, 0.1), (-0.1, 0.1), (-0.5, -0.3)))
    message = refusal(job_of(path=line_to(0.2)), robot)
    assert "point 11 at (0.1100, 0.0000, -0.4500) m: x leaves limits.box_m" in message
    plan(job_of(path=line_to(0.1)), robot)


DIPS = [[-12, -13, 44], [31, -1, -12]]
"""Margins 0.163 and 0.115 at the ends, 0.105 between them."""


@pytest.mark.parametrize(("margin", "fine"), [(0.10, True), (0.11, False)])
def test_near_singular_is_refused_on_the_way_too(job_of, limited, margin, fine):
    """Both ends keep to the limit, alone; what lies between them does not."""
    robot = limited(singularity_margin=margin)
    for end in DIPS:
        assert plan(job_of(path={"shape": "joints", "angles_deg": [end]}), robot) is not None
    job = job_of(path={"shape": "joints", "angles_deg": DIPS})
    if fine:
        assert plan(job, robot).first.reach.margin[0] == pytest.approx(0.105, abs=0.001)
    else:
        message = refusal(job, robot)
        assert "on the way to point 1" in message
        assert "too near to singular (margin 0.105, limits.singularity_margin 0.11)" in message


@pytest.mark.parametrize(("lowest_m", "fine"), [(-0.50, True), (-0.47, False)])
def test_the_box_holds_on_the_way_in_joint_space_too(job_of, limited, lowest_m, fine):
    """The platform starts at z = -0.431 m, ends at -0.448 m, and sinks to -0.492 m between."""
    ends = [[64, 9, 77], [71, 90, 7]]
    box = ((-0.3, 0.3), (-0.3, 0.3), (lowest_m, -0.2))
    robot = limited(box_m=box)
    for end in ends:
        assert plan(job_of(path={"shape": "joints", "angles_deg": [end]}), robot) is not None
    job = job_of(path={"shape": "joints", "angles_deg": ends})
    if fine:
        assert plan(job, robot) is not None
    else:
        message = refusal(job, robot)
        assert "on the way to point 1" in message
        assert "z leaves limits.box_m [-0.47, -0.2] m" in message


@pytest.mark.parametrize(("axis", "side"), [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)])
def test_a_way_may_touch_the_box_and_not_pass_it(zhao, job_of, limited, axis, side):
    """Where it swings beyond both of its ends, to a micrometre."""
    job = job_of(path={"shape": "joints", "angles_deg": [[64, 9, 77], [71, 90, 7]]})
    way = plan(job, zhao).first.reach
    box = np.stack([way.low_m[0], way.high_m[0]], axis=1)
    assert plan(job, limited(box_m=tuple(map(tuple, box)))) is not None
    box[axis, side] += 1e-6 * (1.0 - 2.0 * side)
    assert f"{'xyz'[axis]} leaves limits.box_m" in refusal(
        job, limited(box_m=tuple(map(tuple, box)))
    )


def test_joint_angles_beyond_a_limit(zhao, job_of):
    path = {"shape": "joints", "angles_deg": [[40, 40, 40], [40, 111, 40]]}
    message = refusal(job_of(path=path), zhao)
    assert "point 1 at arm angles (40.00, 111.00, 40.00) deg: arm 2" in message


def test_a_limit_falls_on_the_nearest_whole_step(zhao, job_of):
    path = {"shape": "joints", "angles_deg": [[40, 40, 40], [40, 110, 40]]}
    assert plan(job_of(path=path), zhao).first.lap.counts[1, 1] == 4889  # 110.0025 degrees


def test_the_way_back_of_a_repeat_is_checked(job_of, limited):
    """Arm 1 above 35 degrees means outside a ball: there and back by C, not straight back."""
    robot = limited(arm_deg=(35.0, 110.0)).model_copy(
        update={"homing": limited().homing.model_copy(update={"angle_deg": (50.0, 50.0, 50.0)})}
    )
    corners = [[0.064, 0.06, -0.45], [0.04, 0, -0.45], [0.064, -0.06, -0.45]]
    path = {"shape": "points", "points_m": corners, "spacing_m": 0.005}
    plan(job_of(path=path), robot)
    message = refusal(job_of(path=path, repeats=3), robot)
    assert "of the way back to the start at (0.0640, " in message
    assert "(repeat 2): arm 1 would be at 34." in message


class Answers:
    """An inverse kinematics that is off by something from one call on."""

    def __init__(self, robot, off_rad, after=0):
        self._true = GeometricInverse(robot.geometry)
        self._off = off_rad
        self._after = after
        self.calls = 0

    def angles_rad(self, x_m, y_m, z_m):
        first, second, third = self._true.angles_rad(x_m, y_m, z_m)
        self.calls += 1
        return (first, second + (self._off if self.calls > self._after else 0.0), third)

    def angles_rad_many(self, position_m):
        raise AssertionError("targets are mapped one by one")


@pytest.mark.parametrize("off_rad", [0.2, -0.3, 1.0, 500.0])
def test_a_network_that_disagrees_with_the_geometry_is_refused(zhao, job_of, off_rad, limited):
    message = refusal(job_of(), limited(arm_deg=(-360.0, 360.0)), Answers(zhao, off_rad, after=7))
    assert "point 7 at" in message
    assert "limits.network_deg 10" in message or "arm 2 would be at" in message


@pytest.mark.parametrize("answer", [float("nan"), float("inf"), 1e9])
def test_a_network_that_answers_nonsense_is_refused(zhao, job_of, answer):
    message = refusal(job_of(), zhao, Answers(zhao, answer, after=3))
    assert "point 3: " in message
    assert "the network file must be broken" in message


def test_a_network_that_is_a_little_off_is_what_networks_are_for(zhao, job_of):
    plan(job_of(), zhao, Answers(zhao, np.deg2rad(9.0)))


def test_step_rate_and_speed_limits(job_of, limited, zhao):
    fast = job_of(timing={"mode": "together", "t_pwm_s": 5e-5})
    plan(fast, zhao)
    message = refusal(fast, limited(step_rate_hz=10_000.0))
    assert "t_pwm_s 5e-05 means 20000 Hz" in message
    assert "limits.step_rate_hz of 10000 Hz" in message
    message = refusal(fast, limited(joint_speed_radps=2.0))
    assert "limits.joint_speed_radps of 2 rad/s" in message
    greedy = job_of(timing={"mode": "accelerated", "speed_mps": 0.1, "joint_speed_radps": 9.0})
    assert "timing.joint_speed_radps means 9 rad/s" in refusal(greedy, zhao)


def test_coarse_targets_may_not_swing_beyond_an_arm_limit(job_of, zhao):
    """A curve through coarse targets bulges between them; its arms are checked there too."""
    path = {
        "shape": "circle",
        "centre_m": [0, 0, -0.45],
        "radius_m": 0.05,
        "spacing_m": 0.05,
        "turns": 1,
    }
    timing = {"mode": "accelerated", "speed_mps": 0.1}
    made = plan(job_of(path=path, timing=timing), zhao).first
    low, high = np.rad2deg(made.schedule.angle_range_rad())
    at = np.rad2deg(made.lap.angles_rad)
    between = float((at.max() + high.max()) / 2)
    assert high.max() > at.max() + 0.05
    limits = zhao.limits.model_copy(update={"arm_deg": (-20.0, between)})
    strict = zhao.model_copy(update={"limits": limits})
    message = refusal(job_of(path=path, timing=timing), strict)
    assert "would swing to" in message
    assert "make spacing_m smaller" in message
    assert low.min() < at.min() + 1e-9
