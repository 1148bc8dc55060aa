"""A motion or a measurement that separates what a recording leaves tied, one row a pair of effects.

A lone axis has no job file of ours, so there all is said in words; a delta has its next run, and a
line here for the pairs that are hard to distinguish.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.robot import EffectEntry

Pair = frozenset[str]
SAY_WHAT_PULLS = (
    ". Or say in the robot file what pulls at it, as `gravity` ('deltactl init' has --hanging-nm "
    "and --slope-n for it; 0 where nothing does), and diagnose again"
)
_AXES: dict[Pair, str] = {
    frozenset({"gear_backlash", "joint_friction"}): (
        "repeat the motion with a weight that always pulls one way (play closes, friction stays)"
        "{or_effort}"
    ),
    frozenset({"transmission_error", "encoder_error"}): (
        "read the angle by other means at a few places (a second encoder, or a laser on a mirror "
        "at the axis): a gear's error moves the axis, an encoder's does not"
    ),
    frozenset({"following_lag", "sensor_latency"}): (
        "move the axis by hand against a switch that is recorded by the same clock: late "
        "readings show it late, a late drive does not"
    ),
    frozenset({"following_lag", "viscous_friction"}): (
        "change the drive's gain (friction lags less behind a stiffer drive){or_effort}"
    ),
    frozenset({"gear_ratio", "joint_compliance"}): (
        "measure how far it moves between two places, with its load and without: a wrong ratio "
        "stays, what yields does not{say_what_pulls}"
    ),
    frozenset({"gear_ratio", "sensor_scale"}): (
        "measure one long move of the axis by other means (gauge blocks, a tape, a second encoder)"
    ),
    frozenset({"gear_ratio", "unknown"}): (
        "record again at another speed: the error of a wrong ratio grows with the way, a drift (of "
        "what the axis stands on, of its clock) with the time"
    ),
    frozenset({"home_offset", "joint_compliance"}): (
        "repeat the motion with a known weight on the axis: a yielding joint sags further"
        "{say_what_pulls}"
    ),
    frozenset({"home_offset", "gear_backlash"}): (
        "come to the same places from both sides: play shows twice, an offset once"
    ),
    frozenset({"inertia", "effort_gain"}): (
        "push the axis with a known force (a spring balance, a weight over a pulley) and record it "
        "as `load`"
    ),
    frozenset({"effort_offset", "joint_friction"}): (
        "pull the resting axis either way with a spring balance: friction that differs by "
        "direction shows there, an offset of the effort does not"
    ),
    frozenset({"joint_friction", "stribeck_friction"}): (
        "move at several steady speeds, the slowest just above standstill"
    ),
    frozenset({"joint_friction", "viscous_friction"}): (
        "move at several steady speeds, slow and fast"
    ),
    frozenset({"sensor_offset", "sensor_scale"}): (
        "record again over a wider span of distances, near ones and far ones"
    ),
    frozenset({"sensor_scale", "sensor_crosstalk"}): (
        "record again over a wider span of distances, near ones and far ones"
    ),
    frozenset({"sensor_offset", "sensor_drift"}): "record again from switching on, for longer",
}
_DELTAS: dict[Pair, str] = {
    frozenset({"gear_backlash", "joint_friction"}): (
        "Standing still after approaching from both sides, another payload, or the motor "
        "current would distinguish play from friction."
    ),
    frozenset({"following_lag", "sensor_latency"}): (
        "Recording the arm angles too would distinguish a late drive from late readings."
    ),
    frozenset({"home_offset", "forearm_length"}): (
        "A run through more of the workspace would distinguish them better."
    ),
    frozenset({"home_offset", "sensor_offset"}): (
        "A run with more tilted arms, or arm angles measured, would distinguish them."
    ),
    frozenset({"following_lag", "motor_azimuth"}): (
        "The same path run the other way round would distinguish them."
    ),
}
"""Pairs that are hard to distinguish, and what distinguishes them."""
BY_HAND: tuple[tuple[Pair, str], ...] = (
    (
        frozenset({"gear_backlash", "joint_friction"}),
        "record the motor current (friction draws more of it, play does not), or hang 0.5 kg on "
        "the platform and repeat the run: a load that always pulls one way hides play, friction "
        "stays",
    ),
    (
        frozenset({"following_lag", "sensor_latency"}),
        "record the arm angles (theta_1 to theta_3): a late drive shows in them, late readings do "
        "not",
    ),
    (
        frozenset({"joint_compliance", "upper_arm_length"}),
        "hang 0.5 kg on the platform and read the sensors again: yielding joints sag further, "
        "wrong lengths do not",
    ),
    (
        frozenset({"joint_compliance", "payload"}),
        "weigh the platform with all it carries",
    ),
    (
        frozenset({"home_offset", "sensor_offset"}),
        "measure the height of the platform at home with a gauge, or an arm's angle with a level",
    ),
    (
        frozenset({"home_offset", "gear_backlash"}),
        "turn the arm by hand while its motor holds: play can be felt, a wrong home cannot",
    ),
)
BY_HAND_ALONE: tuple[tuple[str, str], ...] = (
    (
        "base_radius",
        "measure the radii of base and platform with calipers (their difference is all that the "
        "linkage shows)",
    ),
    ("forearm_length", "measure the rods from joint to joint"),
    ("upper_arm_length", "measure the upper arms from axis to joint"),
    ("payload", "weigh the platform with all it carries"),
    ("home_offset", "measure an arm's angle at home with a level"),
    ("motor_azimuth", "measure the distances between the motor axes on the base plate"),
    ("following_lag", "record the arm angles (theta_1 to theta_3)"),
    ("sensor_latency", "record the arm angles (theta_1 to theta_3)"),
    ("sensor_offset", "measure one distance of a sensor with a gauge"),
    ("sensor_scale", "measure two distances of a sensor with a gauge"),
)
"""Measurements that settle what no safe motion can, by a pair of effects or one of them."""
HYSTERESIS = frozenset({"joint_friction", "gear_backlash"})
LONE = "axis"
"""Component of a machine that is one axis."""
OTHERWISE = "repeat the motion with other speeds, spans and rests"


def _ways(
    table: Mapping[Pair, str], finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False
) -> list[str]:
    """What separates a finding from each alternative; empty where the table has nothing.

    pull_said: as in the answer; what the robot file has need not be entered.
    """
    pairs = (frozenset({finding.effect, one.effect}) for one in finding.alternatives)
    say = "" if pull_said else SAY_WHAT_PULLS
    words = {"or_effort": ways.or_effort, "say_what_pulls": say}
    return [table.get(pair, "").format(**words) for pair in pairs]


def beside_friction(
    finding: Finding, findings: Sequence[Finding], known: Sequence[EffectEntry] = ()
) -> bool:
    """Whether an unknown follows the direction of a lone axis though friction or play is found.

    known: effects of the robot file, from an earlier diagnosis. Friction and play are the same
    along the whole travel; what is left of the direction changes along it.
    """
    followed = finding.effect == "unknown" and finding.depends_on == ["direction"]
    there = [*(one.effect for one in findings), *(one.effect for one in known)]
    return followed and any(one in HYSTERESIS for one in there)


UNEVEN = "friction or play of the axis that is not the same all along its travel"
"""What such an unknown is called."""


def telling_apart(findings: Sequence[Finding], pull_said: bool = False) -> list[str]:
    """A sentence for every pair of a lone axis that is tied."""
    lines: dict[Pair, str] = {}
    for finding in findings:
        apart = _ways(_AXES, finding, pull_said=pull_said)
        for other, says in zip(finding.alternatives, apart, strict=True):
            pair = frozenset({finding.effect, other.effect})
            text = f"To tell {finding.effect} from {other.effect}: {says or OTHERWISE}."
            lines.setdefault(pair, text)
    return list(lines.values())


def way_apart(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> str:
    """How a lone machine's finding is told from what it is tied with; empty where no row says."""
    if finding.component != LONE:
        return ""
    return next(filter(None, _ways(_AXES, finding, ways, pull_said)), "")


def asks_for_effort(findings: Sequence[Finding]) -> bool:
    """Whether an effort would tell one of them from what it is tied with."""
    return any(
        "{or_effort}" in _AXES.get(frozenset({finding.effect, one.effect}), "")
        for finding in findings
        if finding.component == LONE
        for one in finding.alternatives
    )


def hint(finding: Finding, ways: Ways = TERMINAL, pull_said: bool = False) -> str:
    """What would distinguish a finding from its alternatives; empty where no line says."""
    if finding.component == LONE:
        said = way_apart(finding, ways, pull_said)
        return f"To tell them apart: {said}." if said else ""
    return next(filter(None, _ways(_DELTAS, finding)), "")


def measurement(effects: frozenset[str]) -> str:
    """What to measure to tell these effects apart."""
    for pair, says in BY_HAND:
        if pair <= effects:
            return says
    for effect, says in BY_HAND_ALONE:
        if effect in effects:
            return says
    return "measure the platform from outside (pos_x to pos_z), or record the arm angles"
