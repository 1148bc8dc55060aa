"""The real command line in an empty folder, and answers that describe a delta."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

from tests.cli.conftest import deltactl as deltactl

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
DELTA = {
    "name": "mine", "base_radius_mm": "120", "platform_radius_mm": "40", "upper_arm_mm": "150",
    "forearm_mm": "320", "microsteps_per_rev": "3200", "gear_ratio": "5",
    "sensors": "xyz",
}  # fmt: skip
WIRED = {
    "step_pins": "17 27 22", "direction_pins": "23,24,25", "enable_pin": "5", "alarm_pins": "none",
    "estop_pin": "26", "xshut_pins": "4 20 21", "arm_deg": "-10 90", "joint_speed_radps": "4",
    "joint_acceleration_radps2": "20", "home_deg": "30 30 30", "step_rate_hz": "20000",
    "approach_speed_radps": "0.5",
}  # fmt: skip


def options(answers: dict[str, str]) -> list[str]:
    return [word for key, text in answers.items() for word in (f"--{key.replace('_', '-')}", text)]
