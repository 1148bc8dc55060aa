"""Where a network may be asked: the region its training data covered.

Inside it the error bound of the file's metadata holds; outside a network answers
smoothly and wrongly, so a target there is refused.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from deltactl.foundation.strict_yaml import StrictModel
from deltactl.models.robot import FloatArray

EDGE_M = 1e-9
"""A target this far outside still counts as inside: rounding of a point on the edge."""

Range = tuple[float, float]


class Cylinder(StrictModel):
    """An upright cylinder about the z axis."""

    shape: Literal["cylinder"] = "cylinder"
    radius_m: Annotated[float, Field(gt=0.0)]
    z_m: Range

    @model_validator(mode="after")
    def _ordered(self) -> Cylinder:
        if self.z_m[0] >= self.z_m[1]:
            raise ValueError("z_m must be [lowest, highest]")
        return self

    def contains(self, x_m: float, y_m: float, z_m: float) -> bool:
        """Whether a point lies inside (NaN does not)."""
        low_m, high_m = self.z_m
        reach_m = self.radius_m + EDGE_M
        inside = x_m * x_m + y_m * y_m <= reach_m * reach_m
        return inside and low_m - EDGE_M <= z_m <= high_m + EDGE_M

    def bounding_box(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner; shapes (3,)."""
        r = self.radius_m
        return np.array([-r, -r, self.z_m[0]]), np.array([r, r, self.z_m[1]])

    def clip(self, position_m: FloatArray) -> FloatArray:
        """The nearest points inside; shape (..., 3)."""
        clipped = np.array(position_m, dtype=np.float64)
        radius_m = np.hypot(clipped[..., 0], clipped[..., 1])
        shrink = self.radius_m / np.maximum(radius_m, self.radius_m)
        clipped[..., :2] *= shrink[..., None]
        clipped[..., 2] = clipped[..., 2].clip(*self.z_m)
        return clipped

    def describe(self) -> str:
        """In words, for messages."""
        return f"r <= {self.radius_m:g} m, {self.z_m[0]:g} <= z <= {self.z_m[1]:g} m"


class Box(StrictModel):
    """A box along the axes of the robot's frame."""

    shape: Literal["box"] = "box"
    x_m: Range
    y_m: Range
    z_m: Range

    @model_validator(mode="after")
    def _ordered(self) -> Box:
        for name, (low_m, high_m) in (("x_m", self.x_m), ("y_m", self.y_m), ("z_m", self.z_m)):
            if low_m >= high_m:
                raise ValueError(f"{name} must be [lowest, highest]")
        return self

    def contains(self, x_m: float, y_m: float, z_m: float) -> bool:
        """Whether a point lies inside (NaN does not)."""
        return (
            self.x_m[0] - EDGE_M <= x_m <= self.x_m[1] + EDGE_M
            and self.y_m[0] - EDGE_M <= y_m <= self.y_m[1] + EDGE_M
            and self.z_m[0] - EDGE_M <= z_m <= self.z_m[1] + EDGE_M
        )

    def bounding_box(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner; shapes (3,)."""
        ranges_m = np.array([self.x_m, self.y_m, self.z_m])
        return ranges_m[:, 0], ranges_m[:, 1]

    def clip(self, position_m: FloatArray) -> FloatArray:
        """The nearest points inside; shape (..., 3)."""
        low_m, high_m = self.bounding_box()
        return np.clip(np.asarray(position_m, dtype=np.float64), low_m, high_m)

    def describe(self) -> str:
        """In words, for messages."""
        ranges = (("x", self.x_m), ("y", self.y_m), ("z", self.z_m))
        return ", ".join(f"{low:g} <= {name} <= {high:g} m" for name, (low, high) in ranges)


Domain = Annotated[Cylinder | Box, Field(discriminator="shape")]
