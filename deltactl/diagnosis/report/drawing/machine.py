"""The drawing of any kind of machine, with its legend."""

from __future__ import annotations

import html
from collections.abc import Sequence

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.drawing.culprits import marks_of
from deltactl.diagnosis.report.drawing.delta import DeltaDrawing
from deltactl.diagnosis.report.drawing.lone import axis_scene, sensor_scene, widened
from deltactl.diagnosis.report.drawing.scene import Scene, hue
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.sureness import called
from deltactl.diagnosis.report.sentences.telling_apart import UNEVEN, beside_friction
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel


def machine_drawing(robot: RobotModel, findings: Sequence[Finding]) -> str:
    """The machine as SVG with the findings' components marked, and a legend, as HTML."""
    marks = marks_of(findings, lone=not isinstance(robot, DeltaRobot))
    if isinstance(robot, RangeSensor):
        marks = widened(marks)
    drawn = _scene(robot).svg(marks)
    return f'<figure class="drawing">{drawn}{_legend(findings, robot)}</figure>'


def _scene(robot: RobotModel) -> Scene:
    if isinstance(robot, DeltaRobot):
        return DeltaDrawing(robot).build()
    if isinstance(robot, RangeSensor):
        return sensor_scene(robot)
    return axis_scene(robot)


def _legend(findings: Sequence[Finding], robot: RobotModel) -> str:
    if not findings:
        return '<p class="note">Nothing is marked, because nothing was found.</p>'
    rows = []
    for number, finding in enumerate(findings, 1):
        what = called(finding)
        if finding.effect == "unknown":
            part = "sensor" if isinstance(robot, RangeSensor) else finding.component
            what = words.unknown(part, finding.depends_on)
            what = UNEVEN if beside_friction(finding, findings, robot.effects) else what
        rows.append(f'<li>{badge(number)}<a href="#finding-{number}">{html.escape(what)}</a></li>')
    found = {f.component for f in findings}
    note = ""
    if isinstance(robot, DeltaRobot):
        note = '<p class="note">Numbers in the drawing are those of this list, not of motors.</p>'
    if any(o.component not in found for f in findings for o in f.alternatives):
        note += '<p class="note">Dashed: parts where the cause could also be.</p>'
    return f'<ol class="legend-list">{"".join(rows)}</ol>{note}'


def badge(number: int) -> str:
    """The number of a finding in its colour, for text."""
    return f'<span class="tag hue{hue(number)}">{number}</span>'
