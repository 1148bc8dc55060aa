"""The answer in a terminal: one screen of 25 lines at 80 columns, whatever was found."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from rich.text import Text

from benchmarks.proofs import one_screen
from deltactl.diagnosis.answer.corrected_robot import lasts, sure
from deltactl.diagnosis.answer.records import (
    Alternative,
    Diagnosis,
    Evidence,
    Finding,
    Known,
    OpenTie,
    ParameterResult,
    PriorSensitivity,
    Thinned,
    Where,
)
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.report.finding import shown_sizes
from deltactl.diagnosis.report.remedies import remedies
from deltactl.diagnosis.report.screen import marked, screen_lines
from deltactl.diagnosis.report.templates import PAGE, PYTHON, TERMINAL, Ways, say
from deltactl.foundation.one_screen import shortened, wrapped
from deltactl.models.effects import CARDS
from deltactl.models.robot import RobotModel, ServoAxis
from tests.axes import axis_rigs

LINES, WIDTH = 25, 80
EFFECTS = sorted({*CARDS} - {"unknown"})
SERVO = ServoAxis(kind="servo_axis", name="elbow", motion="rotary")
LONG = "run.csv: the row 17 of 3000 has text where a number belongs, " * 3


def shown(
    answer: Diagnosis, robot: RobotModel | None = None, most: int = LINES, width: int = WIDTH
) -> list[str]:
    lines = marked(screen_lines(answer, robot, room=(most, width)))
    return [Text.from_markup(line).plain for line in lines]


def finding(effect: str, component: str, sure: float | None, *others: str) -> Finding:
    own = {
        name: ParameterResult(value=0.01234, ci95=[-0.5, 0.6], unit="rad")
        for name in ("size", "period")
    }
    alternatives = [
        Alternative(effect=one, component=component, delta_chi2=1.0, probability=0.2)
        for one in others
    ]
    return Finding(
        effect=effect, component=component, parameters=own, where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9), share_of_mismatch=0.4, probability=sure,
        alternatives=alternatives,
    )  # fmt: skip


def answers(make: Any, parts: Any) -> Iterator[Diagnosis]:
    """Nothing, one, many, ties, unknowns, refusals beside an answer, several recordings."""
    for verdict in ("nothing_missing", "explained", "partly_explained", "unexplained"):
        yield make(verdict)
        yield make(verdict, next_experiment=None)
    for component in ("axis", "motor1"):
        every = [finding(name, component, 0.999) for name in EFFECTS]
        tied = [finding(name, component, 0.5, *EFFECTS[:3], "unknown") for name in EFFECTS]
        nameless = [parts["unknown"](component=component, depends_on=["jerk_of_the_arm"])] * 6
        for findings in (every, tied, nameless, tied[:1], every[:3], [*tied[:4], *nameless]):
            yield make("explained", findings=findings)
            yield make("explained", findings=findings, next_experiment=None)
    crowded = {
        "left_out": [LONG] * 4,
        "not_read": [LONG] * 2,
        "not_held_out": [LONG],
        "doubts": [LONG] * 3,
        "loosely_built": True,
        "thinned": [Thinned(recording=1, rows_used=9, rows=99, stretches=3, span_s=9e4)],
        "known": [
            Known(effect=name, component="axis", probability=0.5, from_these_recordings=True)
            for name in EFFECTS
        ],
        "open_ties": [OpenTie(one=[f"{name} motor1"], other=["payload motor1"], minutes=3.0)
                      for name in EFFECTS[:5]],
        "prior_sensitivity": [
            PriorSensitivity(
                effect=name, component="axis", probability=0.5, narrower=0.1, wider=0.9
            )
            for name in EFFECTS
        ],
    }  # fmt: skip
    for findings in ([], tied, nameless):
        verdict = "partly_explained" if findings else "nothing_missing"
        yield make(verdict, findings=findings, **crowded)


def words(lines: list[str]) -> set[str]:
    """Without marks, as a cut ends a sentence early; of all but the last line, which counts."""
    return {word.strip(".,;:()") for line in lines[:-1] for word in line.split()}


def fits(answer: Diagnosis, robot: RobotModel | None = None) -> None:
    lines = shown(answer, robot)
    assert len(lines) <= LINES, "\n".join(lines)
    assert max(map(len, lines)) <= WIDTH
    whole = shown(answer, robot, most=10_000, width=10_000)
    cut = ("screen.more_findings", "headline.more_there", "screen.unseen", "do.if_confirmed_there")
    more = [say(key, number="", do="") for key in cut]
    more += [say(f"headline.open_{of}", what="", open="") for of in ("one", "each", "some")]
    more += [say("screen.all_unseen", findings="one finding findings"), ""]
    counted = words(more) | {"", *map(str, range(100))}
    assert words(lines) <= words(whole) | counted


@pytest.mark.study
def test_every_answer_fits_on_a_screen_and_breaks_no_word(make: Any, parts: Any) -> None:
    for answer in answers(make, parts):
        fits(answer, SERVO)


@pytest.mark.study
@pytest.mark.parametrize("ways", [TERMINAL, PAGE, PYTHON])
def test_plain_lines_fit_and_name_the_ways_of_their_reader(
    make: Any, parts: Any, ways: Ways
) -> None:
    for answer in answers(make, parts):
        lines = screen_lines(answer, SERVO, ways)
        assert len(lines) <= LINES
        assert max(map(len, lines)) <= WIDTH
        assert ("--" in "".join(lines)) <= (ways is TERMINAL)
        assert lines[0].head
        assert not lines[-1].head


def test_what_the_engine_answers_fits_on_a_screen() -> None:
    robot = ServoAxis(kind="servo_axis", name="forced", motion="linear", inertia=2.0)
    rig = axis_rigs.ForcedRig(coulomb=1.0, viscous=2.0, offset=0.5)
    answer = diagnose_recordings(robot, [rig.record(seed, span_s=15.0) for seed in (1, 2)])
    assert len(answer.findings) >= 2
    fits(answer, robot)


def test_the_parts_come_in_the_order_in_which_they_are_needed(make: Any) -> None:
    text = "\n".join(shown(make("explained")))
    places = [
        text.index(part)
        for part in ("model error is explained", "Do this", "95 % interval", "Does it help?",
                     "What else it could be", "Not visible", "More: --report")
    ]  # fmt: skip
    assert places == sorted(places)


def test_what_a_finding_may_be_instead_is_not_called_invisible(make: Any) -> None:
    alone, beside = (
        "\n".join(
            shown(make("explained", findings=[finding("home_offset", "motor1", 0.5, *others)]))
        )
        for others in ((), ("encoder_error",))
    )
    assert "angle encoder" in alone[alone.index("Not visible") :]
    assert "angle encoder" not in beside[beside.index("Not visible") :]


REFERENCE = re.compile(
    r"findings? (?!of )(\d+(?: \([^)]*\))?(?:(?:, | and )\d+(?: \([^)]*\))?)*)|^(\d+) could"
)


def rows_of(lines: Sequence[str]) -> set[int]:
    return {int(found[1]) for line in lines if (found := re.match(r"(\d+) {2,3}\S.* {2}\S", line))}


def numbers_in(text: str) -> list[int]:
    plain = re.sub(r"\([^)]*\)|in the report \d+ more", "", text)
    return [int(one) for one in re.findall(r"\b\d+\b", plain)]


@pytest.mark.parametrize("most", [pytest.param(16, marks=pytest.mark.study), LINES])
def test_no_line_refers_to_a_finding_without_a_row(make: Any, parts: Any, most: int) -> None:
    cut = 0
    for answer in answers(make, parts):
        lines = shown(answer, SERVO, most=most)
        rows, text = rows_of(lines), " ".join(line.strip() for line in lines)
        assert rows == set(range(1, len(rows) + 1))
        assert bool(rows) == bool(answer.findings), text
        cut += len(rows) < len(answer.findings)
        for line in [*re.split(r"(?<=[.:]) ", text), *lines]:
            for found in REFERENCE.finditer(line):
                assert {*numbers_in(found[1] or found[2])} <= rows, (line, rows)
        named_below = "named below" in text
        assert not named_below or len(rows) == len(answer.findings)
    assert cut


def test_of_very_many_findings_rows_go_before_what_comes_of_them(make: Any) -> None:
    many = [finding("joint_friction", f"joint_{k}", 0.999) for k in range(1, 19)]
    answer = make("explained", findings=many)
    lines = shown(answer)
    assert len(lines) <= LINES
    assert any(line.startswith("Does it help?") for line in lines)
    assert len(rows_of(lines)) >= 8


@pytest.mark.study
@pytest.mark.parametrize(("most", "all_of_them"), [(16, False), (LINES, True)])
def test_what_is_in_the_robot_file_is_counted_right(
    make: Any, parts: Any, most: int, all_of_them: bool
) -> None:
    seen = 0
    for answer in answers(make, parts):
        lines = screen_lines(answer, SERVO, room=(most, WIDTH), saved=all_of_them)
        assert len(lines) <= most, "\n".join(lines)
        assert max(map(len, lines)) <= WIDTH
        text = " ".join(line.strip() for line in lines)
        for start, kept in file_groups(answer, all_of_them).items():
            (said,) = re.findall(rf"{re.escape(start)}[^:]*: (.*?)(?= [A-Z]|$)", text)
            more = re.search(r"in the report (\d+) more|(\d+|one) findings? in the report", said)
            counted = (more[1] or more[2].replace("one", "1")) if more else "0"
            named = [] if more and more[2] else numbers_in(said)
            assert {*named} <= rows_of(lines) & {*kept}
            assert len(named) + int(counted) == len(kept)
            seen += 1
    assert seen


def file_groups(answer: Diagnosis, all_of_them: bool) -> dict[str, list[int]]:
    """The numbers of findings that are written, and of those that are left out."""
    lasting = {k: one for k, one in enumerate(answer.findings, 1) if lasts(one)}
    written = [k for k, one in lasting.items() if all_of_them or sure(one, answer)]
    left = [k for k in lasting if k not in written]
    groups = {"In the robot file": written, "Left out, not certain": left}
    return {start: kept for start, kept in groups.items() if kept}


def test_findings_that_do_not_fit_are_counted(make: Any) -> None:
    many = [finding(name, "axis", 0.999) for name in EFFECTS]
    lines = shown(make("explained", findings=many))
    rows = [line for line in lines if re.match(r"\d+ {2,}\w", line)]
    (more,) = (int(found[1]) for line in lines if (found := re.match(r"and (\d+) more in", line)))
    assert len(rows) >= 2
    assert len(rows) + more == len(many)
    steps = [line for line in lines if re.match(r"\d+\. ", line)]
    (left,) = (int(found[1]) for line in lines if (found := re.search(r"\((\d+) more st", line)))
    assert len(steps) + left == len(remedies(make("explained", findings=many)))


def test_the_table_has_size_interval_and_probability(make: Any) -> None:
    one = finding("home_offset", "motor2", 0.93)
    one.parameters["angle"] = ParameterResult(value=0.02, ci95=[0.018, 0.022], unit="rad")
    (row,) = [line for line in shown(make("explained", findings=[one])) if line.startswith("1  ")]
    size = next(size for name, size in shown_sizes(one) if name == "angle")
    for cell in ("wrong home angle", "motor 2", size.shown, size.interval, "93 %"):
        assert cell in row


def test_less_room_takes_less_but_keeps_the_verdict(make: Any) -> None:
    answer = make("explained")
    small = shown(answer, most=18)
    assert len(small) <= 18
    assert small[0] == shown(answer)[0]


@pytest.mark.parametrize("hostile", ["[bold]x[/bold]", "x\\"])
def test_text_of_others_is_shown_as_it_is(make: Any, hostile: str) -> None:
    answer = make("nothing_missing", left_out=[hostile])
    assert any(hostile in line for line in shown(answer))


def test_a_number_stays_with_a_unit_of_two_words() -> None:
    text = "the friction is 3.00 N m before"
    assert wrapped(text, text.index(" m "))[1].startswith("3.00 N m")


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("1. Do this. Then do that, as it is needed.", "1. Do this."),
        ("1. Do this with a weight (play closes, friction stays), or that.",
         "1. Do this with a weight, or that."),
        ("1. Enter `gravity` (18 %) and diagnose, or measure it by hand.",
         "1. Enter `gravity` (18 %) and diagnose."),
        ("1. Turn each of all the many screws of the axis.",
         "1. Turn each of all the many screws of the axis."),
    ],
)  # fmt: skip
def test_a_sentence_that_is_too_long_ends_as_a_sentence(text: str, left: str) -> None:
    assert " ".join(line.strip() for line in shortened(text, 40, 1)) == left


@pytest.mark.parametrize("most", [12, 16, 20])
def test_no_line_of_a_small_screen_is_cut(make: Any, most: int) -> None:
    assert not [line for line in shown(make("explained"), most=most) if line.endswith("...")]


def test_an_interval_that_is_not_known_is_said(make: Any) -> None:
    late = finding("following_lag", "axis", 0.93)
    late.parameters.clear()
    late.parameters["time"] = ParameterResult(value=0.06, ci95=[0.0, 0.07], unit="s")
    late.parameters["dead_time"] = ParameterResult(value=0.06, ci95=[0.05, 0.13], unit="s")
    (row,) = [line for line in shown(make("explained", findings=[late])) if line.startswith("1  ")]
    assert re.search(r"120 ms +not known +93 %", row)


def delay(time_s: float, dead_s: float) -> Finding:
    """One of which both parts are known well."""
    late = finding("following_lag", "motor1", 0.98)
    late.parameters.clear()
    for name, size_s in (("time", time_s), ("dead_time", dead_s)):
        interval = [0.9 * size_s, 1.1 * size_s]
        late.parameters[name] = ParameterResult(value=size_s, ci95=interval, unit="s")
    return late


def test_the_row_of_a_delay_has_the_whole_and_further_rows_its_parts(make: Any) -> None:
    answer = make("explained", findings=[delay(0.0395, 0.0884)])
    lines = shown(answer)
    (row,) = [line for line in lines if line.startswith("1  ")]
    assert re.search(r"128 ms +not known", row)
    for part, size in (("time constant", "39.5 ms"), ("dead time", "88.4 ms")):
        (line,) = [line for line in lines if line.strip().startswith(part)]
        assert size in line
        assert any(size in step for step in remedies(answer))


def test_a_weak_finding_without_other_causes_may_be_nothing(make: Any) -> None:
    weak, sure = finding("gear_ratio", "axis", 0.53), finding("home_offset", "axis", 0.96)
    text = " ".join(shown(make("explained", findings=[sure, weak], next_experiment=None)))
    assert "2 could be nothing (47 %)." in text
    assert "No other known effect" not in text
    text = " ".join(shown(make("explained", findings=[sure], next_experiment=None)))
    assert "No other known effect fits these readings as well." in text


@pytest.mark.study
def test_answers_of_drawn_machines_fit_one_screen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)  # names of recordings are as long as they are typed
    few = ("--axes", "12", "--arms", "2", "--deltas", "3", "--seed", "9402")
    assert one_screen.main(["--keep", "kept", *few]) == 0, capsys.readouterr().out
