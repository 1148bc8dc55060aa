"""Dry friction as physics has it: bristles that bend before anything slides.

LuGre (Canudas de Wit et al. 1995, IEEE Trans. Autom. Control 40, 419) for a mass, Dahl (1968) for a
shaft that a bearing winds up, and the play operator that both are in the limit of stiff bristles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.proof.axis.motions import FloatArray


@dataclass(frozen=True)
class LuGre:
    """Friction of a sliding mass, SI units of its motion.

    coulomb: force of steady sliding. breakaway: how much more it is near standstill; it falls off
    with exp(-(v / stribeck_speed)^2). viscous: force per speed. bristle: stiffness before sliding.
    """

    coulomb: float
    breakaway: float
    stribeck_speed: float
    viscous: float
    bristle: float
    damper: float

    def most(self, speed: FloatArray) -> FloatArray:
        """Dry force of steady sliding at a speed."""
        falls: FloatArray = np.exp(-((speed / self.stribeck_speed) ** 2))
        most: FloatArray = self.coulomb + self.breakaway * falls
        return most

    def along(self, speed: FloatArray, step_s: float, of_place: FloatArray | float) -> FloatArray:
        """Force (n,) that a known motion meets; the bristles bend by an implicit step.

        of_place: factor of the dry part, (n,) or one.
        """
        most = np.maximum(self.most(speed) * of_place, 1e-12)
        grow = 1.0 / (1.0 + self.bristle * np.abs(speed) * step_s / most)
        bent = linear_recursion(grow, grow * speed * step_s)
        rate = np.diff(bent, prepend=0.0) / step_s
        force: FloatArray = self.bristle * bent + self.damper * rate + self.viscous * speed
        return force


def linear_recursion(factor: FloatArray, forcing: FloatArray) -> FloatArray:
    """z[k] = factor[k] z[k-1] + forcing[k] from z = 0."""
    z, out = 0.0, []
    for a, b in zip(factor.tolist(), forcing.tolist(), strict=True):
        z = a * z + b
        out.append(z)
    return np.array(out)


def play(driven: FloatArray, width: FloatArray | float, start: float) -> FloatArray:
    """The play operator: the output rests until the drive has crossed `width`.

    start: where in the play it begins, -1 to 1.
    """
    half = 0.5 * width * np.ones_like(driven)
    low, high = (driven - half).tolist(), (driven + half).tolist()
    at, out = float(driven[0] + start * half[0]), []
    for least, most in zip(low, high, strict=True):
        at = least if at < least else min(at, most)
        out.append(at)
    return np.array(out)


def wound_up(
    driven: FloatArray, width: FloatArray | float, slip: float, start: float
) -> FloatArray:
    """An axis whose bearing (Dahl) winds up the shaft that drives it.

    A bearing of force F winds a shaft of stiffness k up by F / k either way, so that the axis is
    behind by half of width = 2 F / k. slip: motion of the axis over which the friction builds up;
    with no slip this is the play operator.
    """
    half = (0.5 * width * np.ones_like(driven)).tolist()
    steps = np.diff(driven, prepend=driven[0]).tolist()
    places = driven.tolist()
    z, out = -start, []
    for place, step, h in zip(places, steps, half, strict=True):
        way = 1.0 if step > 0.0 else -1.0
        left = max(1.0 - way * z, 0.0)
        z += left / slip * step / (1.0 + h * left / slip)
        z = 1.0 if z > 1.0 else max(z, -1.0)
        out.append(place - h * z)
    return np.array(out)
