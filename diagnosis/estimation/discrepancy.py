"""How far the operator of an effect may be from the thing itself.

Where the ends of a bar are is geometry: what a wrong length leaves is noise. A bearing, a spring
or a stop is messier than any operator with two numbers, and what it leaves must not be taken
for a second effect. So a further effect has to explain a share of what those there explain.
"""

from __future__ import annotations

from diagnosis.plants.candidate import Candidate, Term

EXACT = 1e-4
"""One percent of the size: beside the right one of these, what is left is noise."""
BLUR: dict[str, tuple[float, float]] = {
    "lost_steps": (0.0005, 0.0005),  # when within a reading's time
    "following_lag": (0.001, 0.003),  # a drive is not of first order
    "sensor_latency": (0.001, 0.003),  # filters inside the sensor
    "thermal_expansion": (0.003, 0.003),  # one time constant of several
    "sensor_drift": (0.001, 0.001),  # one time constant of several
    "transmission_error": (0.001, 0.003),  # one harmonic of several
    "contact": (0.002, 0.002),  # a platform that slips and sticks where it is pressed on
    "gear_backlash": (0.001, 0.012),  # inside the play, friction and inertia decide
    "joint_compliance": (0.012, 0.012),  # inertia beside weight, damping beside the spring
    "joint_friction": (0.001, 0.012),  # breaks loose, creeps, changes with load and speed
    "payload": (0.012, 0.012),  # acts through compliance
    "resonance": (0.001, 0.012),  # one mode of many
    "viscous_friction": (0.001, 0.012),  # acts through compliance
}
"""Shares of what an effect explains that its own imperfect operator may leave, with the reason:
in what follows the pose alone, and in all the rest."""
RELATED = {
    # Inertia on a spring rings; the operator of compliance has no inertia.
    ("joint_compliance", "resonance"): 1.0,
    ("payload", "resonance"): 1.0,
    # Arms that press on a stop give way.
    ("contact", "joint_compliance"): 0.01,
    ("contact", "payload"): 0.01,
    ("contact", "resonance"): 0.01,
}
"""The same for a new effect that follows from the old one's physics."""
POSE_ALONE = frozenset(
    {
        "base_radius",
        "forearm_length",
        "frame_tilt",
        "gear_ratio",
        "home_offset",
        "motor_azimuth",
        "sensor_crosstalk",
        "sensor_offset",
        "sensor_scale",
        "upper_arm_length",
    }
)
"""Effects that are the same whenever the robot is in the same place: play and lag are not, so
what play leaves cannot look like a wrong length."""
FREE = 4.0
"""So many times more for a free shape, which fits many things a little."""


def blur_of(term: Term, new: Candidate | None = None) -> float:
    """Share of what a term explains that it may leave in the shape of a new effect.

    Without one: of a free shape, which may have any.
    """
    effect = term.candidate.effect
    static, other = BLUR.get(effect, (EXACT, EXACT))
    if new is None:
        return other
    return RELATED.get((effect, new.effect), static if new.effect in POSE_ALONE else other)
