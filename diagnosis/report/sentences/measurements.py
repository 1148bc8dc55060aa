"""Measurements by hand that settle what no safe motion can, one row a pair of effects."""

from __future__ import annotations

_TABLE: tuple[tuple[frozenset[str], str], ...] = (
    (
        frozenset({"gear_backlash", "joint_friction"}),
        "record the motor current (friction draws more of it, play does not), or hang 0.5 kg on "
        "the platform and repeat the run: a load that keeps the teeth on one flank hides play, "
        "friction stays",
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
_ALONE: tuple[tuple[str, str], ...] = (
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


def measurement(effects: frozenset[str]) -> str:
    """What to measure to tell these effects apart."""
    for pair, says in _TABLE:
        if pair <= effects:
            return says
    for effect, says in _ALONE:
        if effect in effects:
            return says
    return "measure the platform from outside (pos_x to pos_z), or record the arm angles"
