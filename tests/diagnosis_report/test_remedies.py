"""What a mechanic is to do: a line for every effect, with the machine's own lengths."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.diagnosis.answer.finding import Table
from deltactl.diagnosis.answer.records import Alternative, Evidence, Finding, ParameterResult, Where
from deltactl.diagnosis.report.headline import headline
from deltactl.diagnosis.report.names import followed
from deltactl.diagnosis.report.pairs import beside
from deltactl.diagnosis.report.remedies import LAYERS, advice, remedies, remedy
from deltactl.diagnosis.report.templates import TERMINAL
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.models.effects import CARDS
from deltactl.models.effects.lone_axis import effort_effects
from deltactl.models.robot import RangeSensor, RobotModel, ServoAxis, StepperAxis
from deltactl.models.robot_files import load_robot_model

ROBOT = load_robot_model(CONFIG_FOLDER / "zhao-2023.yaml")
SERVO = ServoAxis(kind="servo_axis", name="mount", motion="rotary")
SLIDE = ServoAxis(kind="servo_axis", name="carriage", motion="linear")
STEPPER = StepperAxis(kind="stepper_axis", name="table")
SENSOR = RangeSensor(kind="range_sensor", name="tag")
EFFECTS = [name for name, card in CARDS.items() if card.words.noun]


def found(effect: str, component: str, value: float, unit: str, *others: str) -> Finding:
    return Finding(
        effect=effect,
        component=component,
        parameters={"size": ParameterResult(value=value, ci95=[value, value], unit=unit)},
        where=Where(axes=[], times_s=[]),
        evidence=Evidence(delta_chi2=100.0, p=1e-9),
        share_of_mismatch=0.9,
        alternatives=[Alternative(effect=o, component=component, delta_chi2=1.0) for o in others],
    )


def test_every_effect_has_a_remedy() -> None:
    assert set(EFFECTS) == {name for name, card in CARDS.items() if card.remedy((), ("", "size"))}


@pytest.mark.parametrize("effect", sorted({*EFFECTS} - {"unknown"}))
def test_each_is_one_plain_sentence(effect: str) -> None:
    line = remedy(found(effect, "motor2", 0.01, "rad"), ROBOT)
    assert line.endswith(".")
    assert "{" not in line
    assert "_" not in line.replace("--save-robot", "")


def test_an_arm_is_given_by_its_true_length() -> None:
    line = remedy(found("upper_arm_length", "arm3", 0.0029, "m"), ROBOT)
    assert "Set the upper arm of arm 3 to 252.9 mm (not 250.0 mm) in the robot file" in line
    base = remedy(found("base_radius", "frame", -0.001, "m"), ROBOT)
    assert "249.0 mm (not 250.0 mm)" in base


def test_a_drive_is_late_by_dead_time_and_time_constant() -> None:
    late = found("following_lag", "axis", 0.0, "s")
    late.parameters["dead_time"] = ParameterResult(value=0.0064, ci95=[0.006, 0.007], unit="s")
    line = remedy(late, SERVO)
    assert "late by a dead time of 6.40 ms." in line
    late.parameters["time"] = ParameterResult(value=0.0481, ci95=[0.04, 0.05], unit="s")
    line = remedy(late, SERVO)
    assert "a dead time of 6.40 ms and a time constant of 48.1 ms" in line


@pytest.mark.parametrize(
    ("robot", "effect", "parameter", "value", "unit", "says"),
    [
        (SENSOR, "sensor_offset", "offset", -0.124, "m", "Add 124 mm to what the sensor reads"),
        (SENSOR, "sensor_offset", "offset", 0.124, "m", "Take 124 mm off what the sensor reads"),
        (SENSOR, "sensor_scale", "scale", 1.014, "1", "by 1.0140"),
        (SERVO, "home_offset", "angle", -0.01, "rad", "Add 0.573 degrees to the commands"),
        (SERVO, "gear_ratio", "scale", 1.00069, "1", "Divide the commands of the axis by 1.000690"),
        (SERVO, "gear_ratio", "scale", 1.5, "1", "turns angles into counts"),
        (SLIDE, "gear_ratio", "scale", 1.002, "1", "Divide the steps per mm (or counts) of the"),
        (SLIDE, "gear_ratio", "scale", 1.2, "1", "the lead of the screw, and the teeth and pitch"),
        (SLIDE, "gear_backlash", "width", 4e-5, "m", "replace the nut of the screw, tension the"),
        (SLIDE, "joint_compliance", "stiffness", 1e5, "N/m", "Tension the belt of the axis"),
        (SLIDE, "joint_friction", "width", 4e-5, "m", "Free the guides of the axis"),
        (STEPPER, "gear_ratio", "scale", 2.0, "1", "microstep switches"),
        (STEPPER, "gear_ratio", "scale", 0.9993, "1", "0.0700 % less far"),
        (ROBOT, "home_offset", "angle", 0.01, "rad", "0.573 degrees lower than it should"),
        (ROBOT, "gear_ratio", "scale", 1.001, "1", "too little for a wrong gear"),
    ],
)
def test_what_to_do_depends_on_the_machine_and_the_way_it_is_off(
    robot: RobotModel, effect: str, parameter: str, value: float, unit: str, says: str
) -> None:
    named = found(effect, "motor1" if robot is ROBOT else "axis", value, unit)
    named.parameters[parameter] = named.parameters.pop("size")
    line = remedy(named, robot)
    assert says in line


def test_how_to_enter_what_stays_is_one_step(make: Any) -> None:
    both = [found("home_offset", "axis", 0.01, "rad"), found("joint_friction", "axis", 1.0, "N m")]
    lines = remedies(make("explained", findings=both), SERVO)
    assert sum("--save-robot" in line for line in lines) == 1
    assert lines[-1].endswith(f": {TERMINAL.save}.")
    play = remedies(
        make("explained", findings=[found("gear_backlash", "axis", 0.01, "rad")]), SERVO
    )
    assert play[-1] == lines[-1], "a robot file holds play too"


def test_what_tells_causes_apart_is_a_step_before_the_repair(make: Any) -> None:
    """An order of steps, where a repair used to be taken back in its second half."""
    tied = found("gear_backlash", "axis", 0.01, "rad", "joint_friction")
    tied = tied.model_copy(update={"probability": 0.55})
    own = found("home_offset", "axis", 0.01, "rad")
    answer = make("explained", findings=[own, tied], next_experiment=None)
    first, *lines = remedies(answer, SERVO)
    assert "cause of finding 2" in first
    (conditional,) = [line for line in lines if line.startswith("If finding 2 is confirmed")]
    assert "dead zone" in conditional
    assert not any("rule out" in line or "sure" in line for line in (first, *lines))


def test_a_correction_that_is_right_for_either_cause_is_made_at_once() -> None:
    tied = found("gear_backlash", "motor1", 0.01, "rad", "joint_friction")
    tied = tied.model_copy(update={"probability": 0.55})
    do, either, *_ = remedy(tied, ROBOT).split(". ")
    assert do.startswith("Take up the play")
    assert "right for either" in either
    assert "right for either" not in remedy(tied, ROBOT, certain=False)


def test_nobody_is_asked_to_rule_out_what_is_in_no_list(make: Any) -> None:
    tied = found("gear_backlash", "axis", 0.01, "rad", "unknown")
    lines = remedies(make("explained", findings=[tied], next_experiment=None), SERVO)
    assert not any("To find the cause" in line or "is confirmed" in line for line in lines)


def test_what_is_not_certain_is_recorded_only_when_all_is_asked_for(make: Any) -> None:
    tied = found("transmission_error", "motor1", 0.01, "rad", "sensor_offset")
    own = found("home_offset", "motor1", 0.01, "rad")
    first, *lines = remedies(make("explained", findings=[tied, own]), ROBOT)
    assert "record the proposed run" in first
    assert ["home stop" in line for line in lines] == [True, False, False], "sure ones first"
    assert lines[-1].endswith("--save-robot NEW.yaml --all.")


def test_where_nothing_is_tied_no_run_is_asked_for(make: Any) -> None:
    answer = make("explained", findings=[found("home_offset", "motor1", 0.01, "rad")])
    assert "the home stop" in remedies(answer)[0]
    assert not any("run proposed" in line for line in remedies(answer))


def test_nothing_is_advised_for_what_has_no_name() -> None:
    assert remedy(found("unknown", "range_x", 0.001, "m"), ROBOT) == ""


@pytest.mark.parametrize("effect", sorted({*EFFECTS} - {"unknown"}))
@pytest.mark.parametrize("parameter", ["scale", "width", "torque"])
def test_a_slide_hears_of_no_gearbox_and_of_a_gain_only_where_a_servo_drives_it(
    effect: str, parameter: str
) -> None:
    named = found(effect, "axis", 1.001, "m")
    named.parameters[parameter] = named.parameters.pop("size")
    line = remedy(named, SLIDE)
    assert "gear" not in line
    assert " gain" not in line or "where a servo drives it" in line


@pytest.mark.parametrize(
    ("follows", "unit", "says"),
    [
        ("time", "rad", "Record again from switching on"),
        ("speed", "rad", "several steady speeds"),
        ("position", "N", "have the controller add a table of it"),
        ("jerk", "rad", "find out what the unknown error at the axis comes with: it follows jerk"),
    ],
)
def test_an_unknown_has_a_line_that_says_what_tells_more(
    make: Any, parts: Any, follows: str, unit: str, says: str
) -> None:
    size = {"size_rms": ParameterResult(value=0.1, ci95=[0.09, 0.11], unit=unit)}
    finding = parts["unknown"](component="axis", depends_on=[follows], parameters=size)
    axis = ServoAxis(kind="servo_axis", name="elbow", motion="rotary")
    (line,) = remedies(make("unexplained", findings=[finding]), axis)
    assert says.lower() in line.lower()
    assert followed(follows) in line


@pytest.mark.parametrize("machine", sorted(LAYERS))
def test_every_machine_has_a_line_for_unknowns_and_fills_it(machine: str) -> None:
    for driver in ("position", "position.force", "speed", "direction", "time", "load", "effort"):
        text = advice(machine, "unknown", driver, 0.0)
        assert text is not None
        assert "{" not in text.format(part="the axis", follows="the time")


def test_a_constant_force_and_dry_friction_do_not_contradict_each_other() -> None:
    kinds = effort_effects("linear")
    force = kinds["effort_offset"].sentence("axis", {"offset": -3.2})
    friction = kinds["joint_friction"].sentence("axis", {"torque": 20.0})
    todo = advice("slide", "effort_offset", "offset", -3.2) or ""
    assert "moves nothing" not in force + todo
    assert "always acts" not in force + todo
    assert "whichever way the axis moves" in force
    assert "whichever way it moves" in todo
    assert "at rest" not in force + todo, "readings at rest are not used"
    assert "against its motion" in friction


def test_drives_that_are_all_late_are_one_line(make: Any) -> None:
    def late(motor: int, dead_s: float, time_s: float) -> Finding:
        sizes = {
            name: ParameterResult(value=value, ci95=[0.9 * value, 1.1 * value], unit="s")
            for name, value in (("time", time_s), ("dead_time", dead_s))
        }
        return Finding(
            effect="following_lag", component=f"motor{motor}", parameters=sizes,
            where=Where(axes=[], times_s=[]), evidence=Evidence(delta_chi2=1e4, p=1e-300),
            share_of_mismatch=0.3, probability=0.98,
        )  # fmt: skip

    found = [late(1, 0.09, 0.038), late(2, 0.074, 0.029), late(3, 0.046, 0.041)]
    answer = make("explained", findings=found)
    (line,) = remedies(answer)
    assert line == (
        "Command motors 1, 2 and 3 earlier, or raise the gains in their control (which shortens no"
        " dead time): they are late by 128 ms, 103 ms and 87.0 ms."
    )
    assert headline(answer) == (
        "The model error is explained by drives of motors 1, 2 and 3 that follow late."
    )


def sized(effect: str, name: str, value: float) -> Finding:
    one = found(effect, "axis", value, "rad")
    ends = [0.8 * value, 1.2 * value]
    one.parameters = {name: ParameterResult(value=value, ci95=ends, unit="rad")}
    return one


def test_a_zero_that_play_may_have_moved_is_looked_at_after_the_play(make: Any) -> None:
    home, play = sized("home_offset", "angle", 0.0011), sized("gear_backlash", "width", 0.002)
    first, second, *_ = remedies(make("explained", findings=[home, play]), STEPPER)
    assert first.startswith("Take up the play")
    assert second.startswith("Then look at the zero of the axis again: it is 0.0630 degrees")
    (says,) = beside(home, make("explained", findings=[home, play]))
    assert "Half of the play is 0.0573 degrees" in says
    far = sized("home_offset", "angle", 0.0026)
    first, *_ = remedies(make("explained", findings=[far, play]), STEPPER)
    assert first.startswith("Take 0.149 degrees off"), "no play of this width moves a zero so far"
    assert beside(far, make("explained", findings=[far, play])) == []
    near = sized("home_offset", "angle", -0.0003)
    assert beside(near, make("explained", findings=[near, play]))


def test_a_table_beside_a_correction_is_taken_after_it(make: Any) -> None:
    ratio = found("gear_ratio", "axis", 1.01, "")
    table = Table(follows="position", lowest=0.0, highest=1.0, size=[1e-4] * 11, unit="m")
    rest = found("unknown", "axis", 1e-4, "m").model_copy(
        update={"depends_on": ["position"], "table": table}
    )
    for findings, first in (([ratio, rest], True), ([rest], False)):
        lines = remedies(make("partly_explained", findings=findings), SLIDE)
        (line,) = [one for one in lines if "a table of 11 points" in one]
        assert ("Make the corrections above first" in line) == first


def test_no_table_is_asked_for_that_hardly_helps(make: Any) -> None:
    table = Table(follows="position", lowest=0.0, highest=1.0, size=[1e-4] * 11, unit="m")
    rest = found("unknown", "axis", 1e-4, "m")
    left_m = make().fit.rms_after_m
    for times, asked in ((1.04, False), (2.0, True)):
        changes = {"depends_on": ["position"], "table": table, "left_without_m": times * left_m}
        lines = remedies(
            make("partly_explained", findings=[rest.model_copy(update=changes)]), SLIDE
        )
        assert any("a table of 11 points" in one for one in lines) == asked
