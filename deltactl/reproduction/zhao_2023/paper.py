"""What Zhao 2023 prints: Tables 3 and 4, and the sizes named in section 4. Metres, mm/s."""

from __future__ import annotations

Three = tuple[float, float, float]

NETWORK_RMS_M: dict[tuple[str, float], Three] = {
    ("circle", 0.002): (0.0038, 0.0056, 0.0112),
    ("circle", 0.006): (0.0045, 0.0057, 0.0112),
    ("circle", 0.01): (0.0059, 0.0064, 0.0111),
    ("circle", 0.02): (0.0041, 0.0047, 0.0115),
    ("heart", 0.002): (0.0040, 0.0067, 0.0128),
    ("heart", 0.006): (0.0040, 0.0069, 0.0128),
    ("heart", 0.01): (0.0040, 0.0068, 0.0126),
    ("heart", 0.02): (0.0072, 0.0081, 0.0132),
    ("spiral", 0.002): (0.0086, 0.0041, 0.0124),
    ("spiral", 0.006): (0.0097, 0.0068, 0.0068),
    ("spiral", 0.01): (0.0183, 0.0101, 0.0069),
    ("spiral", 0.02): (0.0125, 0.0079, 0.0100),
}
"""Table 3, neural networks, by curve and T_PWM."""

GEOMETRY_RMS_M: dict[str, Three] = {
    "circle": (0.0122, 0.0238, 0.1015),
    "heart": (0.0148, 0.0125, 0.0447),
    "spiral": (0.0149, 0.0087, 0.0271),
}
"""Table 3, inverse kinematics at T_PWM = 0.006 s."""

SPEED_MM_PER_S = {0.002: 46.5250, 0.006: 15.5083, 0.01: 9.3050, 0.02: 4.66525}
"""Table 4; its fifth row is a stray line of Table 3."""

GREATEST: dict[tuple[str, str], str] = {
    ("circle", "network"): "under 10 mm each",
    ("circle", "geometry"): "20, 40, 1100 mm",
    ("heart", "network"): "50, 50, 80 % less",
    ("spiral", "network"): "33, 40, 42.5 % less",
}
"""Section 4, largest errors behind Figures 10 to 15. 1100 mm is no typing error of ours; the
robot is not that large, and 98 % less than it is still 22 mm."""
