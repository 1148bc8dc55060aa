"""Where the page draws the robot, and how it holds a move to the limits."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.controller.contract import SensorStatus
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.models.linkage import forward
from deltactl.models.linkage.skeleton import Skeleton
from deltactl.web.behind.known_robots import KnownRobot, KnownRobots
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.site import Site

ZHAO = KnownRobot.of(CONFIG_FOLDER / "zhao-2023.yaml")
HOME = (0.0, 0.0, -0.45)
angle = st.floats(math.radians(-15), math.radians(100))


@settings(deadline=None)
@given(angles=st.tuples(angle, angle, angle))
def test_forearms_as_drawn_have_their_length_and_end_at_the_platform(
    angles: tuple[float, float, float],
) -> None:
    place = forward(ZHAO.linkage, np.array(angles)).position_m
    frame = Skeleton.of(ZHAO.robot.geometry)
    wrists = place + frame.platform_radius_m * frame.outward
    lengths = np.linalg.norm(wrists - frame.elbows_m(angles), axis=1)
    assert lengths == pytest.approx(frame.forearm_m, abs=1e-9)
    for placed in frame.links(angles, (place[0], place[1], place[2])):
        rotation = np.array(placed.rotation)
        assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-4)
        assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-4)


@settings(deadline=None)
@given(
    x_m=st.floats(-1.0, 1.0), y_m=st.floats(-1.0, 1.0), z_m=st.floats(-1.2, 0.2)
)  # fmt: skip
def test_a_move_is_held_to_the_limits(x_m: float, y_m: float, z_m: float) -> None:
    held = ZHAO.held(HOME, (x_m, y_m, z_m))
    assert ZHAO.allows(held)
    if ZHAO.allows((x_m, y_m, z_m)):
        assert held == (x_m, y_m, z_m)


@pytest.mark.parametrize(
    ("point_m", "says"),
    [((0.0, 0.0, -3.0), "the arms do not reach"), ((0.0, 0.0, -0.45), "^$"),
     ((0.4, 0.0, -0.35), "arm 1 may turn from -20 to 110 degrees")],
)  # fmt: skip
def test_a_refused_point_says_which_limit(point_m: tuple[float, float, float], says: str) -> None:
    assert re.search(says, ZHAO.limit_at(point_m))


@pytest.mark.parametrize("name", ["zhao-2023.yaml", "uzunovic-2013.yaml", "gripper-delta.yaml"])
def test_the_point_that_the_page_suggests_is_within_reach(name: str) -> None:
    """Home, as the fields show it: in mm, to a hundredth."""
    known = KnownRobot.of(CONFIG_FOLDER / name)
    assert known.home_m is not None
    x_m, y_m, z_m = (round(1e3 * value, 2) * 1e-3 for value in known.home_m)
    assert known.allows((x_m, y_m, z_m))


def test_the_first_job_of_a_robot_of_ones_own_is_shown_first(tmp_path: Path) -> None:
    """What `init` writes: a robot file and a job beside it."""
    robot = tmp_path / "my-delta.yaml"
    robot.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8"))
    (tmp_path / "another.yaml").write_text("robot: their-delta.yaml\n")
    site = Site(DaemonLink(None), KnownRobots(robot), tmp_path / "runs", tmp_path / "work")
    assert site.first_file == "heart.yaml"
    (tmp_path / "my-circle.yaml").write_text("name: little\nrobot: my-delta.yaml\n")
    assert site.first_file == "my-circle.yaml"
    assert site.files()["my-circle.yaml"].parent == tmp_path


@settings(deadline=None)
@given(point=st.tuples(*[st.floats(-0.2, 0.2)] * 3))
def test_ranges_put_the_platform_where_it_is(point: tuple[float, float, float]) -> None:
    ranges = [offset + value for offset, value in zip((0.6, 0.6, 0.9), point, strict=True)]
    sensors = [
        SensorStatus(axis, distance, 0.0, "good", 9.0, "ok")
        for axis, distance in zip("xyz", ranges, strict=True)
    ]
    assert ZHAO.measured(tuple(sensors)) == pytest.approx(point, abs=1e-12)
    bad = SensorStatus("z", 0.9, 0.0, "jump", 9.0, "ok")
    assert ZHAO.measured((*sensors[:2], bad)) is None


@pytest.mark.parametrize("name", ["zhao-2023.yaml", "uzunovic-2013.yaml", "gripper-delta.yaml"])
def test_the_work_area_ends_where_the_robot_may_not_go_further(name: str) -> None:
    known = KnownRobot.of(CONFIG_FOLDER / name)
    area = known.work_area
    assert area is not None
    for x_m, y_m, z_m in area.edge_m:
        assert known.allows((x_m, y_m, z_m))
        assert not known.allows((1.1 * x_m, 1.1 * y_m, z_m))
        assert z_m > area.floor_m
