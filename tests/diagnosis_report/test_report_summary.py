"""The summary in the terminal."""

from __future__ import annotations

import io
import math
from typing import Any

import pytest
from rich.console import Console

from diagnosis.answer.records import (
    Alternative,
    Evidence,
    Fit,
    NotTestable,
    OpenTie,
    ParameterResult,
    SmallestDetectable,
    Unexplained,
    Where,
)
from diagnosis.report.phrases.sizes import number, quantity, sizes
from diagnosis.report.phrases.sureness import odds
from diagnosis.report.phrases.words import EFFECTS, effect, followed, listed, spelled
from diagnosis.report.sentences.finding_words import where_line
from diagnosis.report.sentences.headline import NOT_TOLD, headline
from diagnosis.report.sentences.summary import (
    ENDED_EARLY,
    SO_LITTLE,
    plain_lines,
    summary_lines,
    unexplained_line,
)
from diagnosis.report.sentences.telling import NOISE, told
from diagnosis.report.sentences.ways import TERMINAL
from models.effects import VOCABULARY
from models.effects.lone_axis import command_effects, effort_effects, sensor_effects

VERDICTS = ("nothing_missing", "explained", "partly_explained", "unexplained")
NAN = math.nan


def shown(lines: list[str], width: int = 400) -> str:
    out = io.StringIO()
    console = Console(file=out, width=width, highlight=False)
    for line in lines:
        console.print(line)
    return out.getvalue()


@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        ("nothing_missing", "Nothing is missing"),
        ("explained", "The mismatch is explained by free play in the gear or coupling of motor 2"),
        (
            "partly_explained",
            "Part of the mismatch is explained by free play in the gear or coupling",
        ),
        ("unexplained", "enters at motor 3 and follows the angle of arm 3"),
    ],
)
def test_the_verdict_comes_first(make: Any, verdict: str, says: str) -> None:
    lines = plain_lines(make(verdict))
    assert lines[0] == headline(make(verdict))
    assert says in lines[0]
    assert len(lines) > 4


def test_where_most_is_left_the_headline_says_so(make: Any) -> None:
    answer = make("partly_explained")
    most = answer.unexplained.model_copy(update={"share_of_mismatch": 0.9})
    says = headline(answer.model_copy(update={"unexplained": most}))
    assert says.startswith("Only a small part of the mismatch is explained by")
    assert "90 % of it is left" in says


def test_a_finding_is_told_with_size_interval_surety_and_rivals(make: Any) -> None:
    text = "\n".join(plain_lines(make("explained")))
    assert "Whole play: 0.498 degrees (95 % sure between 0.476 and 0.521)." in text
    assert "Beyond doubt" in text
    assert "No other known effect fits these readings as well." in text
    assert (
        "This recording cannot tell it from a wrong home angle of motor 1 "
        "or a drift of the x sensor." in text
    )
    assert "from 83.2 s on" in text
    assert "0.0 to 240" not in text  # the whole recording is no place in time
    assert "Drag" not in text  # a second parameter that tells a mechanic nothing


def test_before_and_after_stand_against_the_noise_and_on_held_out_data(make: Any) -> None:
    text = "\n".join(plain_lines(make("explained")))
    assert "before 4.10 mm, after 2.21 mm; the noise alone is 2.10 mm" in text
    # (4.2^2 - 2.24^2) / (4.2^2 - 2.1^2) = 0.954
    assert (
        "(causes were chosen with all of it): before 4.20 mm, after 2.24 mm (93 % of what" in text
    )


def test_one_off_events_are_not_expected_in_another_run(make: Any, parts: Any) -> None:
    fit = Fit(
        rms_before_m=0.003, rms_after_m=0.0016, noise_floor_m=0.0016,
        holdout_rms_before_m=0.0017, holdout_rms_after_m=0.0017, holdout="run",
    )  # fmt: skip
    once = "\n".join(plain_lines(make("explained", findings=[parts["lost_steps"]()], fit=fit)))
    assert "what happens once does not come back in another run" in once
    lasting = "\n".join(plain_lines(make("explained", fit=fit)))
    assert "after 1.70 mm (no gain there)" in lasting


def test_moments_are_given_to_the_hundredth(parts: Any) -> None:
    moment = ParameterResult(value=73.81, ci95=[73.81, 73.8300], unit="s")
    (size,) = sizes("lost_steps", "time", moment)
    assert size.text == "73.81 s (95 % sure between 73.81 and 73.83)"


def test_what_it_could_not_see_is_grouped_and_what_it_could_is_in_peoples_units(make: Any) -> None:
    text = "\n".join(plain_lines(make("explained")))
    assert "could not show periodic errors of the angle encoders of motors 1, 2 and 3" in text
    assert "free play in the gear or coupling of motor 2 (0.17 degrees)" in text
    assert "a wrong gear ratio of motor 1 (0.30 % off what the robot file says)" in text
    assert "softer than 35000 N m/rad" in text


def test_a_share_left_is_only_told_where_it_is_more_than_noise(make: Any) -> None:
    left = Unexplained(share_of_mismatch=0.0, says=NOISE)
    text = "\n".join(plain_lines(make("explained", unexplained=left)))
    assert "Unexplained:" not in text
    assert NOISE in text
    rest = Unexplained(share_of_mismatch=0.38, depends_on=["theta_2"], says="")
    text = "\n".join(plain_lines(make("partly_explained", unexplained=rest)))
    assert "Unexplained: 38 % of the mismatch. It follows the angle of arm 2." in text


@pytest.mark.parametrize("verdict", VERDICTS)
def test_figures_that_are_not_known_are_never_printed_as_nan(
    make: Any, parts: Any, verdict: str
) -> None:
    hollow = parts["backlash"](
        parameters={"width": ParameterResult(value=NAN, ci95=[NAN, NAN], unit="rad")},
        evidence=Evidence(delta_chi2=NAN, p=NAN),
        share_of_mismatch=NAN,
    )
    fit = Fit(
        rms_before_m=NAN, rms_after_m=NAN, noise_floor_m=NAN,
        holdout_rms_before_m=NAN, holdout_rms_after_m=NAN,
    )  # fmt: skip
    lines = plain_lines(make(verdict, findings=[hollow], fit=fit, false_alarm_p=NAN))
    text = "\n".join(lines)
    assert "nan" not in text.lower().replace("resonance", "")
    assert "not known" in text
    assert "could not be computed" in text
    assert "not proved" in text


def test_markup_in_names_is_shown_and_not_obeyed(make: Any, parts: Any) -> None:
    evil = parts["backlash"](says="the gear of [red]motor[/red] [link=x] \\", component="[bold]m")
    text = shown(summary_lines(make("explained", findings=[evil])))
    assert "The gear of [red]motor[/red] [link=x] \\." in text
    assert "[bold]m" in text
    assert "[bold]1." not in text


def test_plain_and_marked_up_lines_say_the_same(make: Any) -> None:
    found = [line for line in shown(summary_lines(make("explained"))).splitlines() if line]
    assert found == plain_lines(make("explained"))


def test_many_findings_are_counted_in_the_headline(make: Any, parts: Any) -> None:
    kinds = ["gear_backlash", "joint_friction", "home_offset", "gear_ratio"]
    many = [parts["backlash"](effect=kinds[k // 3], component=f"motor{k % 3 + 1}")
            for k in range(12)]  # fmt: skip
    assert "and 2 more, named below" in headline(make("explained", findings=many))
    assert "more" not in headline(make("explained", findings=many[:3]))
    assert "couplings of motors 1, 2 and 3" in headline(make("explained", findings=many[:3]))
    numbered = [
        x for x in plain_lines(make("explained", findings=many)) if x[:2].strip(".").isdigit()
    ]
    assert len(numbered) == 12


def test_many_stretches_of_time_are_counted(parts: Any) -> None:
    where = Where(axes=[], times_s=[(float(k), k + 0.5) for k in range(9)], regime="")
    line = where_line(parts["backlash"](where=where), (0.0, 240.0))
    assert line == (
        "It shows from 0.0 to 0.5 s, from 1.0 to 1.5 s, from 2.0 to 2.5 s, from 3.0 to 3.5 s "
        "and 5 more times."
    )


def test_a_linear_axis_has_millimetres_and_newtons(make: Any, parts: Any) -> None:
    friction = parts["backlash"](
        effect="joint_friction",
        component="axis",
        says="dry friction brakes the axis",
        parameters={
            "torque": ParameterResult(value=20.4, ci95=[19.9, 20.9], unit="N"),
            "asymmetry": ParameterResult(value=0.05, ci95=[0.02, 0.08], unit="1"),
        },
    )
    fit = Fit(
        rms_before_m=0.02, rms_after_m=0.0005, noise_floor_m=0.0004,
        holdout_rms_before_m=0.021, holdout_rms_after_m=0.0006, unit="m",
    )  # fmt: skip
    text = "\n".join(plain_lines(make("explained", findings=[friction], fit=fit)))
    assert "Force: 20.40 N (95 % sure between 19.90 and 20.90)" in text
    assert "orque" not in text
    assert "Asymmetry: 5.0 % (95 % sure between 2.0 and 8.0)" in text
    assert "friction in the axis" in text
    assert "before 20.0 mm, after 0.500 mm" in text
    fit = fit.model_copy(update={"unit": "rad"})
    assert "before 1.15 degrees" in "\n".join(plain_lines(make("explained", fit=fit)))


@pytest.mark.parametrize(
    ("value", "unit", "parameter", "text"),
    [
        (0.0052, "s", "time", "5.2 ms"),
        (81.0, "s", "time_constant", "81 s"),
        (0.0175, "rad", "angle", "+1.0 degrees"),
        (-0.0021, "m", "length_error", "-2.1 mm"),
        (1.0035, "1", "scale", "+0.35 %"),
        (0.12, "kg", "mass", "+120 g"),
        (-0.0089, "1", "strain", "-8.9 mm per m"),
        (math.inf, "N m/rad", "stiffness", "any size"),
        (math.nan, "m", "offset", "not known"),
    ],
)
def test_units_of_people(value: float, unit: str, parameter: str, text: str) -> None:
    assert quantity(value, unit, parameter) == text


def test_intervals_keep_two_digits_of_their_half_width() -> None:
    ends = [[0.0, 0.002], [-0.003, -0.001], [-0.001, 0.001]]
    result = ParameterResult(value=[0.001, -0.002, 0.0], ci95=ends, unit="rad")
    texts = [size.text for size in sizes("frame_tilt", "rotation", result)]
    assert texts[0] == "+0.057 degrees (95 % sure between 0.000 and +0.115)"
    assert len(texts) == 3
    open_end = ParameterResult(value=5000.0, ci95=[3000.0, 1e300], unit="N m/rad")
    (size,) = sizes("joint_compliance", "stiffness", open_end)
    assert size.text == "5000 N m/rad (95 % sure above 3000)"


def test_rounding_never_leaves_a_minus_before_nothing() -> None:
    assert number(-0.0004, 2) == "0.00"
    assert number(-1234.6, 0) == "-1235"


def test_odds_are_rounded_and_bounded() -> None:
    assert odds(0.31) == "about 31 of 100"
    assert odds(0.9999) == "nearly all"
    assert odds(0.0123) == "about 1 in 81"
    assert odds(1e-9) == "less than 1 in a million"


def test_every_effect_of_every_chain_has_words() -> None:
    chains = [VOCABULARY, command_effects("rotary"), effort_effects("linear"), sensor_effects()]
    names = {name for chain in chains for name in chain}
    assert names <= set(EFFECTS)
    for name in names:
        assert "_" not in effect(name, "motor1")


def test_words_for_places_and_drivers() -> None:
    assert effect("sensor_scale", "range_x") == "a wrong scale of the x sensor"
    assert effect("new_effect", "motor9") == "new effect at motor9"
    assert followed("theta_2 [rad]") == "the angle of arm 2"
    assert spelled("it follows range_x at motor1") == (
        "it follows where the platform is along x at motor 1"
    )
    for text in ("lost_steps motor1", "lost_steps@motor1", "lost_steps at motor1"):
        assert spelled(text) == "steps lost by motor 1"
    assert spelled("gear_backlash motor2 / joint_friction motor2") == (
        "free play in the gear or coupling of motor 2 / bearing friction in motor 2"
    )
    assert listed(["a", "b", "c"], "or") == "a, b or c"
    assert listed([]) == ""


def test_smallest_of_the_findings_come_first(make: Any) -> None:
    first = SmallestDetectable(
        effect="payload", component="platform", parameter="mass", value=0.02, unit="kg"
    )
    given = make("explained").smallest_detectable
    lines = plain_lines(make("explained", smallest_detectable=[first, *given]))
    line = next(line for line in lines if "Detection limits" in line)
    assert line.index("free play") < line.index("mass")


@pytest.mark.parametrize(("probability", "is_open"), [(None, True), (0.82, True), (0.97, False)])
def test_a_probable_finding_is_not_called_open(
    make: Any, parts: Any, probability: float | None, is_open: bool
) -> None:
    rival = Alternative(effect="home_offset", component="motor2", delta_chi2=3.0)
    found = parts["backlash"](alternatives=[rival], probability=probability)
    text = "\n".join(plain_lines(make("explained", findings=[found])))
    assert ("remains open" in text or "this recording cannot tell" in text) is is_open


def test_many_untested_effects_are_counted(make: Any) -> None:
    hidden = [NotTestable(effect=name, component="motor3", why="") for name in list(EFFECTS)[:9]]
    text = "\n".join(plain_lines(make("explained", not_testable=hidden)))
    assert "5 more kinds of effect" in text
    text = "\n".join(plain_lines(make("explained", not_testable=hidden[:5])))
    assert "1 more kind of effect" in text


def test_it_says_where_the_search_ended_early(make: Any) -> None:
    said = ENDED_EARLY.format(way=TERMINAL.all_compared)
    assert said in shown(summary_lines(make(ended_early=True)))
    assert said not in shown(summary_lines(make()))


def test_a_rival_of_a_finding_is_not_out_of_sight(make: Any, parts: Any) -> None:
    hidden = [NotTestable(effect="joint_compliance", component="motor1", why="no load")]
    rival = Alternative(effect="joint_compliance", component="motor1", delta_chi2=20.0)
    alone, tied = (
        "\n".join(plain_lines(make("explained", not_testable=hidden, findings=[found])))
        for found in (parts["backlash"](), parts["backlash"](alternatives=[rival]))
    )
    assert "could not show" in alone
    assert "could not show" not in tied


def limit(component: str, value: float) -> SmallestDetectable:
    return SmallestDetectable(
        effect="home_offset", component=component, parameter="angle", value=value, unit="rad"
    )


def test_a_limit_is_said_once_for_all_joints_and_not_above_what_was_found(
    make: Any, parts: Any
) -> None:
    every = [limit("motor1", 0.001), limit("motor2", 0.002), limit("motor3", 0.001)]
    text = "\n".join(plain_lines(make("explained", smallest_detectable=every)))
    assert "motors 1, 2 and 3 (at most 0.11 degrees)" in text
    home = parts["backlash"](
        effect="home_offset", component="motor2",
        parameters={"angle": ParameterResult(value=-0.0005, ci95=[-0.0006, -0.0004], unit="rad")},
    )  # fmt: skip
    found = make("explained", smallest_detectable=every, findings=[home])
    assert "Detection limits" not in "\n".join(plain_lines(found))


@pytest.mark.parametrize("smallest", [1.003, 0.003])
@pytest.mark.parametrize(("found", "told"), [(0.98, True), (1.02, True), (1.001, False)])
def test_a_limit_of_a_scale_is_held_against_what_was_found_of_it(
    make: Any, parts: Any, smallest: float, found: float, told: bool
) -> None:
    least = SmallestDetectable(
        effect="gear_ratio", component="motor2", parameter="scale", value=smallest, unit="1"
    )
    ratio = parts["backlash"](
        effect="gear_ratio", component="motor2",
        parameters={"scale": ParameterResult(value=found, ci95=[0.9, 1.1], unit="1")},
    )  # fmt: skip
    answer = make("explained", smallest_detectable=[least], findings=[ratio])
    text = "\n".join(plain_lines(answer))
    assert ("(0.30 % off what the robot file says)" in text) == told


def test_where_no_run_helps_no_motion_is_proposed(make: Any, parts: Any) -> None:
    rival = Alternative(
        effect="joint_friction", component="motor2", delta_chi2=3.0, probability=0.4
    )
    tied = parts["backlash"](alternatives=[rival], probability=0.6)
    tie = OpenTie(one=["gear_backlash motor2"], other=["joint_friction motor2"], minutes=8.0)
    open_ended = make("explained", findings=[tied], next_experiment=None, open_ties=[tie])
    text = "\n".join(plain_lines(open_ended))
    assert "No safe run" in text
    assert "would distinguish play from friction" not in text
    asked = make("explained", findings=[tied], next_experiment=None)
    assert "would distinguish play from friction" in "\n".join(plain_lines(asked))


def test_so_little_that_it_calls_for_nothing(make: Any) -> None:
    rest = Unexplained(share_of_mismatch=0.004, p=1e-9, depends_on=["pos_z"])
    assert SO_LITTLE in "\n".join(plain_lines(make("explained", unexplained=rest)))
    rest = rest.model_copy(update={"share_of_mismatch": 0.04})
    assert SO_LITTLE not in "\n".join(plain_lines(make("partly_explained", unexplained=rest)))


def test_more_than_noise_that_nothing_names_is_not_called_improbable(make: Any) -> None:
    faint = make("unexplained", findings=[], false_alarm_p=0.6, probability_nothing_missing=0.995)
    assert headline(faint) == NOT_TOLD
    assert "below 1 %" not in headline(faint)


def test_a_rest_that_is_too_little_is_said_to_be_in_one_sentence(make: Any) -> None:
    rest = Unexplained(
        share_of_mismatch=0.004, p=1e-9, depends_on=["velocity_3"], component="motor3"
    )
    named = [one for one in make("explained").findings if one.effect != "unknown"]
    answer = told(make("partly_explained", findings=named, unexplained=rest))
    little = answer.fit.model_copy(update={"rms_after_m": 0.1 * answer.fit.rms_before_m})
    assert unexplained_line(answer) == (
        "Unexplained: under 1 % of the mismatch, too little to act on; it follows the speed of"
        " motor 3."
    )
    assert headline(answer).startswith("Part of the mismatch is explained by")
    explained = answer.model_copy(update={"fit": little})
    assert headline(explained).startswith("Nearly all of the mismatch is explained by")


@pytest.mark.parametrize(
    ("sure", "says"), [(0.99, "Nothing is missing: "), (0.68, "Probably nothing is missing (68 %")]
)
def test_nothing_is_as_sure_as_it_is_said_to_be(make: Any, sure: float, says: str) -> None:
    answer = make("nothing_missing", findings=[], probability_nothing_missing=sure)
    assert headline(answer).startswith(says)


def test_nothing_missing_beside_a_rest_of_no_noise_speaks_of_no_noise(make: Any) -> None:
    fit = make("nothing_missing").fit.model_copy(update={"scatter_within_m": 1e-6})
    says = headline(make("nothing_missing", findings=[], fit=fit))
    assert says.endswith("as far as this recording shows.")


def test_odds_that_the_rest_of_the_evidence_denies_are_not_told(make: Any, parts: Any) -> None:
    """A test on few readings may see nothing in what all of them together make sure."""
    evidence = Evidence(delta_chi2=30.0, p=0.11)
    finding = parts["backlash"](evidence=evidence, probability=0.97, alternatives=[])
    answer = make(
        "explained", findings=[finding], false_alarm_p=0.4, probability_nothing_missing=0.001
    )
    text = " ".join(plain_lines(answer))
    assert "of 100 recordings" not in text
    assert "No single test on so few independent readings shows it" in text
    assert "97 %" in text
