"""A range sensor that looks at places or at a moving target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.proof.axis.commanded import Sizes
from deltactl.proof.axis.friction import play
from deltactl.proof.axis.motions import FloatArray, Motion


@dataclass(frozen=True)
class RangeSensor:
    """The motion is the true distance, never below the nearest that it can measure."""

    motion: Motion
    wander: FloatArray
    """Temperature over the same time, -1 to 1."""

    def clean(self, sizes: Sizes, rows_s: FloatArray, ideal: bool = False) -> FloatArray:
        """Noiseless ranges (n,) at the rows' true times."""
        motion = self.motion
        seen = motion.position
        if "hysteresis" in sizes:
            seen = play(seen, sizes["hysteresis"]["width"], 0.0)
        late_s = sizes.get("sensor_latency", {}).get("time", 0.0)
        seen = np.interp(rows_s - late_s, motion.t_s, seen)
        since_s = rows_s - rows_s[0]
        read = seen * sizes.get("sensor_scale", {}).get("scale", 1.0)
        read = read + sizes.get("sensor_offset", {}).get("offset", 0.0)
        read = read + sizes.get("sensor_crosstalk", {}).get("curvature", 0.0) * seen**2
        if "sensor_drift" in sizes:
            drift = sizes["sensor_drift"]
            read = read - drift["offset"] * np.expm1(-since_s / drift["time_constant"])
        if "temperature" in sizes:
            warm = np.interp(rows_s, motion.t_s, self.wander)
            read = read + sizes["temperature"]["size"] * warm
        if "stripes" in sizes:
            stripes = sizes["stripes"]
            read = read + stripes["size"] * np.sin(2.0 * np.pi * seen / stripes["period"])
        if "reflection" in sizes:
            bump = sizes["reflection"]
            read = read + bump["size"] * np.exp(-(((seen - bump["at"]) / bump["within"]) ** 2))
        return read
