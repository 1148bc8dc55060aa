"""The moment at which a lasting jump of a joint explains most, by a scan of whitened readings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.candidates import lost_steps
from deltactl.diagnosis.plants.delta.model import MOTOR, DeltaModel
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import DELTA_FITS
from deltactl.diagnosis.plants.delta.point import end_to_end
from deltactl.models.effects import Port

TIME = "time"
LOSS_95 = 3.841
"""95 % point of chi-square with one degree of freedom."""


@dataclass(frozen=True, slots=True)
class Jump:
    """A jump at the time at which readings show it best, and between which ends they may."""

    candidate: Candidate
    time_s: float
    interval_s: tuple[float, float]


def jumps(
    model: DeltaModel, noise: ChannelsNoise, left: FloatArray, free: FloatArray, late_s: float = 0.0
) -> dict[str, Jump]:
    """For each joint the jump at the moment at which it explains most of the residual (n c,).

    free: whitened columns (m, p) that are fitted beside it, each in its prior spread. late_s: delay
    of the readings.
    """
    drive, inputs = model.robot.drive, model.inputs()
    t_s = model.readings.t_s
    if drive is None:
        return {}
    times = t_s[noise.rows % len(t_s)]
    order = np.argsort(times, kind="stable")[::-1]
    times, beside = times[order], free[order]
    taken, white = Absorbed(free), noise.whiten(left)
    residual = white - free @ taken.sizes(white)
    edge_s = DELTA_FITS.edge * float(np.ptp(times))
    earliest_s, latest_s = float(times.min()) + edge_s, float(times.max()) - edge_s
    inside = (times > earliest_s) & (times < latest_s)
    inside[:-1] &= times[:-1] != times[1:]  # all readings of a moment together
    found = {}
    for place in (one for one in inputs if one.startswith(MOTOR)):
        change = end_to_end(inputs[place])
        column = noise.whiten(-drive.rad_per_step * change)[order]
        along = np.cumsum(column * residual[order])[inside]
        power = np.cumsum(column**2)
        shared = np.cumsum(column[:, None] * beside, axis=0)[inside]
        own = power[inside] - np.sum(taken.root_of(shared.T) ** 2, axis=0)
        usable = own > DELTA_FITS.least_own * power[-1]
        gain = np.where(usable, along**2 / np.maximum(own, 1e-30), 0.0)
        if gain.any():
            within, period_s = times[inside], model.readings.period_s
            near = within[usable & (gain > gain.max() - LOSS_95)]
            at_s = float(within[int(np.argmax(gain))]) - 0.5 * period_s - late_s
            # The first reading that shows a jump comes up to one period after it.
            ends_s = float(near.min()) - period_s - late_s, float(near.max()) - late_s
            found[place] = Jump(lost_steps(place, at_s), at_s, ends_s)
    return found


def late_of(terms: Iterable[Term]) -> float:
    """How late the readings are by terms at work [s]."""
    late = (t for t in terms if t.candidate.kind.port is Port.CLOCK)
    return sum(float(t.candidate.values(t.at)[TIME]) for t in late)
