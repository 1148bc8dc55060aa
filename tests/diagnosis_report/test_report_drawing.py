"""The drawing of the machine and its marks."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from deltactl.charts.scenes import BADGE_RADIUS, Mark, badge_places, hull
from deltactl.diagnosis.answer.records import Alternative
from deltactl.diagnosis.report.machines import (
    DeltaDrawing,
    axis_parts_of,
    axis_scene,
    machine_drawing,
    parts_of,
    sensor_scene,
)
from deltactl.models.effects import VOCABULARY
from deltactl.models.effects.lone_axis import command_effects, effort_effects, sensor_effects


def part(drawing: str, name: str) -> str:
    found = re.search(rf'<g class="([^"]*)" data-part="{name}">', drawing)
    assert found, name
    return found[1]


def test_every_component_of_the_vocabulary_is_on_the_drawing(parts: Any) -> None:
    names = {one.name for one in DeltaDrawing(parts["delta"]()).build().parts}
    for kind in VOCABULARY.values():
        for component in kind.components:
            marked = parts_of(kind.name, component)
            assert marked, (kind.name, component)
            assert set(marked) <= names


def test_every_effect_of_a_lone_machine_is_on_its_drawing(parts: Any) -> None:
    *axes, sensor = parts["lone"]()
    names = {one.name for one in axis_scene(axes[0]).parts}
    for chain in (command_effects("rotary"), effort_effects("linear")):
        for name in (*chain, "unknown"):
            assert set(axis_parts_of(name, "axis")) <= names
    assert {"sensor"} <= {one.name for one in sensor_scene(sensor).parts}
    for name in (*sensor_effects(), "unknown"):
        finding = parts["backlash"](effect=name, component="axis")
        assert "hit" in part(machine_drawing(sensor, [finding]), "sensor")


def test_the_culprit_is_marked_and_only_it(parts: Any) -> None:
    drawing = machine_drawing(parts["delta"](), [parts["backlash"]()])
    assert part(drawing, "gear2") == "part solid hit hue1"
    assert drawing.count(" hit hue") == 1
    assert drawing.count('class="badge') == 1
    assert "backlash in the gear or coupling of motor 2" in drawing


def test_alternatives_elsewhere_are_dashed(parts: Any) -> None:
    finding = parts["backlash"](
        alternatives=[
            Alternative(effect="sensor_offset", component="range_y", delta_chi2=1.0),
            Alternative(effect="gear_ratio", component="motor2", delta_chi2=1.0),
        ]
    )
    drawing = machine_drawing(parts["delta"](), [finding])
    assert part(drawing, "sensor_y") == "part solid maybe hue1"
    assert part(drawing, "gear2") == "part solid hit hue1"
    assert "Dashed" in drawing


def test_common_components_mark_all_their_parts(parts: Any) -> None:
    warm = parts["backlash"](effect="thermal_expansion", component="arms")
    late = parts["backlash"](effect="sensor_latency", component="sensors")
    drawing = machine_drawing(parts["delta"](), [warm, late])
    for name in ("upper_arm1", "forearm3"):
        assert part(drawing, name) == "part solid hit hue1"
    for axis in "xyz":
        assert part(drawing, f"sensor_{axis}") == "part solid hit hue2"


def test_nothing_found_marks_nothing(parts: Any) -> None:
    drawing = machine_drawing(parts["delta"](), [])
    assert " hit" not in drawing
    assert "nothing was found" in drawing


def test_everything_lies_inside_the_picture(parts: Any) -> None:
    findings = [parts["backlash"](component=f"motor{k}") for k in (1, 2, 3)]
    for robot in (parts["delta"](), *parts["lone"]()):
        drawing = machine_drawing(robot, findings)
        found = re.search(r'viewBox="(\S+) (\S+) (\S+) (\S+)"', drawing)
        assert found
        left, top, width, height = (float(x) for x in found.groups())
        outlines = " ".join(re.findall(r'points="([^"]+)"', drawing))
        points = re.findall(r"(-?[\d.]+),(-?[\d.]+)", outlines)
        points += re.findall(r'c?x="(-?[\d.]+)" c?y="(-?[\d.]+)"', drawing)
        assert len(points) > 8
        for x, y in points:
            assert left <= float(x) <= left + width
            assert top <= float(y) <= top + height


def test_a_robot_that_cannot_be_assembled_is_drawn_all_the_same(parts: Any) -> None:
    robot = parts["delta"]()
    robot = robot.model_copy(
        update={"geometry": robot.geometry.model_copy(update={"forearm_m": 0.05})}
    )
    assert "gear2" in machine_drawing(robot, [parts["backlash"]()])


def test_a_robot_without_sensors_has_none_in_its_drawing(parts: Any) -> None:
    robot = parts["delta"]().model_copy(update={"sensors": None})
    assert "sensor" not in machine_drawing(robot, [])


def test_the_outline_of_a_square_with_points_inside() -> None:
    corners = {(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)}
    assert set(hull([*corners, (0.5, 0.5), (0.2, 0.9), (0.5, 0.0)])) == corners


def test_numbers_of_findings_do_not_cover_each_other(parts: Any) -> None:
    """Two at the gear of one motor, two at the motor beside it, on a robot as drawn."""
    marks = {
        name: [Mark(2 * place + 1), Mark(2 * place + 2)]
        for place, name in enumerate(("gear2", "motor2", "gear3", "motor3", "upper_arm3"))
    }
    scene = DeltaDrawing(parts["delta"]()).build()
    at = np.array([place for place, _ in badge_places(scene.parts, marks)])
    apart = np.linalg.norm(at[:, None] - at[None], axis=-1) + 1e9 * np.eye(len(at))
    assert len(at) == 10
    assert apart.min() >= 2.0 * BADGE_RADIUS


def test_numbers_in_the_drawing_of_a_delta_are_said_to_be_no_motors(parts: Any) -> None:
    (axis, *_), finding = parts["lone"](), parts["backlash"]()
    assert "not of motors" in machine_drawing(parts["delta"](), [finding])
    assert "not of motors" not in machine_drawing(axis, [finding])


def test_two_unknown_errors_of_one_axis_are_not_called_the_same(parts: Any) -> None:
    slide, *_ = parts["lone"]()
    both = [parts["unknown"](component="axis", depends_on=[name]) for name in ("speed", "position")]
    drawing = machine_drawing(slide, both)
    assert "an unknown error at the axis that follows the speed" in drawing
    assert "an unknown error at the axis that follows the position" in drawing
