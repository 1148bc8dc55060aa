"""Questions about a delta robot, and what hardware needs besides."""

from __future__ import annotations

from dataclasses import replace

from deltactl.firmware_py.describing.asked_of_all import GEAR, MICROSTEPS, NAME
from deltactl.firmware_py.describing.question import Question
from deltactl.models.robot import LEAST_RATIO, too_small_ratio

LEAST_MM, MOST_MM = 1.0, 9999.0


def _in_metres(size: float) -> str:
    if size <= 0.0:
        return ""
    return f"must not be below {LEAST_MM:g} mm; is it in metres? Then write {1e3 * size:g}"


GEAR_OF_ARM = replace(GEAR, least=LEAST_RATIO, too_small=too_small_ratio)
DELTA: tuple[Question, ...] = (
    NAME,
    Question(
        "base_radius_mm",
        "Base radius: from the middle to a motor axis, mm",
        least=LEAST_MM,
        most=MOST_MM,
        too_small=_in_metres,
    ),
    Question(
        "platform_radius_mm",
        "Platform radius: from its middle to a joint, mm",
        least=LEAST_MM,
        most=MOST_MM,
        too_small=_in_metres,
    ),
    Question(
        "upper_arm_mm",
        "Upper arm: from the motor axis to the elbow, mm",
        least=LEAST_MM,
        most=MOST_MM,
        too_small=_in_metres,
    ),
    Question(
        "forearm_mm",
        "Forearm: from the elbow to the platform's joint, mm",
        least=LEAST_MM,
        most=MOST_MM,
        too_small=_in_metres,
    ),
    MICROSTEPS,
    GEAR_OF_ARM,
    Question(
        "sensors",
        "Ranging sensors that see the platform: three along x, y and z (xyz), or none?",
        "xyz",
        ("xyz", "none"),
    ),
)
WIRING: tuple[Question, ...] = (
    Question("step_pins", "STEP pins of motors 1, 2, 3 (BCM numbers)", count=3),
    Question("direction_pins", "DIR pins of motors 1, 2, 3", count=3),
    Question("enable_pin", "ENA pin of the drives, or none"),
    Question("alarm_pins", "ALM pins of drives 1, 2, 3, or none", count=3),
    Question("estop_pin", "E-stop pin (normally closed to ground), or none"),
    Question("xshut_pins", "XSHUT pins of sensors x, y, z", count=3, unless=(("sensors", "none"),)),
    Question("arm_deg", "Lowest and highest arm angle, degrees (0 level, positive down)", count=2),
    Question("step_rate_hz", "Most steps a second of a motor (a Pi sends up to 20000)"),
    Question("joint_speed_radps", "Fastest an arm may turn, rad/s"),
    Question("joint_acceleration_radps2", "Fastest it may gain speed, rad/s2"),
    Question("approach_speed_radps", "How fast it goes to where a job begins, rad/s (say 0.5)"),
    Question(
        "home_deg",
        "Angles of arms 1, 2, 3 at the stops or jig where they are put, degrees",
        count=3,
    ),
)
"""What hardware needs besides, and nobody can guess; a file without it runs simulated only."""
