"""A new effect is one file: it is hidden, found, sized, worded, drawn, corrected and documented."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.machines import marks_of
from deltactl.diagnosis.report.screen import sentences
from deltactl.firmware_py.program.coverage import robot_coverage
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.effects import CARDS, VOCABULARY, register
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.reference.write import pages

ZHAO = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
SOURCE = '''
"""A cable that pulls an arm further the more it is stretched, from half a radian on."""

import numpy as np

from deltactl.models.effects.card import Compensated, Drawing, EffectCard, Rule, Words
from deltactl.models.effects.kind import MOTORS, EffectKind, Parameter, scalar
from deltactl.models.effects.kind import Port


def _operate(flow, index, values, memory):
    stretched = np.maximum(flow.angles_rad[:, index] - 0.5, 0.0)
    flow.angles_rad[:, index] += scalar(values, "pull") * stretched**2


EFFECT = EffectKind(
    name="cable_pull",
    port=Port.ARM,
    components=MOTORS,
    parameters=(Parameter("pull", "1/rad", -0.5, 0.5, typical=0.05),),
    operate=_operate,
    says=lambda component, v: f"a cable pulls {component} by {v['pull']:.3f} per radian",
    pose_alone=True,
)
CARD = EffectCard(
    name=EFFECT.name,
    kind=EFFECT,
    words=Words(noun="a cable that pulls at {part}", regime="where {part} is far down"),
    remedies={"": "give the cable of {part} more slack"},
    drawing=Drawing(motor="gear"),
    rule=Rule.SUM,
    compensated=Compensated.INVERSE,
)
'''
TRUE = 0.08


@pytest.fixture(scope="module")
def added(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The effect, from a file outside the package, for the tests of this module."""
    path = tmp_path_factory.mktemp("effects") / "cable_pull.py"
    path.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    register([module.CARD])
    yield
    del CARDS["cable_pull"], VOCABULARY["cable_pull"]


@pytest.fixture(scope="module")
def answer(added: None, delta: DeltaRobot, record: Any) -> Diagnosis:
    """Of a robot in which it is hidden at motor 2."""
    hidden = EffectEntry(effect="cable_pull", component="motor2", parameters={"pull": TRUE})
    return diagnose_recordings(delta, [record(hidden)])


def test_it_is_named_and_sized(answer: Diagnosis) -> None:
    assert [(one.effect, one.component) for one in answer.findings] == [("cable_pull", "motor2")]
    ((value, low, high),) = answer.findings[0].parameters["pull"].components
    assert low < TRUE < high
    assert value == pytest.approx(TRUE, rel=0.05)


def test_it_is_worded_and_drawn(answer: Diagnosis, delta: DeltaRobot) -> None:
    finding = answer.findings[0]
    assert finding.says.startswith("a cable pulls motor 2 by 0.0")
    assert finding.where.regime == "where motor 2 is far down"
    text = "\n".join(sentences(answer, delta))
    assert "a cable that pulls at motor 2" in text
    assert "Give the cable of motor 2 more slack" in text
    assert next(iter(marks_of(answer.findings, single=False))) == "gear2"


def test_it_is_written_to_a_corrected_file_and_compensated(
    answer: Diagnosis, tmp_path: Path
) -> None:
    corrected = tmp_path / "corrected.yaml"
    save_corrected(ZHAO, answer, corrected)
    robot = load_robot(corrected)
    (entry,) = robot.effects
    assert entry.parameters["pull"] == pytest.approx(TRUE, rel=0.05)
    (covered,) = robot_coverage(robot).compensated
    assert (covered.effect, covered.how) == ("cable_pull", "in the inverse kinematics")


def test_it_is_documented(added: None) -> None:
    assert "| `cable_pull` | `motor1` to `motor3` | `pull` [" in pages()["effects.md"]
