"""The moment at which a lasting jump of a joint explains most, by a scan of whitened readings."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.candidates import lost_steps
from deltactl.diagnosis.plants.delta.model import MOTOR, DeltaModel
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import DELTA_FITS
from deltactl.diagnosis.plants.delta.point import end_to_end


def jumps(
    model: DeltaModel, noise: ChannelsNoise, left: FloatArray, free: FloatArray
) -> dict[str, Candidate]:
    """For each joint the jump at the moment at which it explains most of what is left (n c,).

    free: whitened columns (m, p) that are fitted beside it, each in its prior spread.
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
            at_s = float(times[inside][int(np.argmax(gain))])
            found[place] = lost_steps(place, at_s - 0.5 * model.readings.period_s)
    return found
