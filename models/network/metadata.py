"""What a network file says about itself, as JSON in one of its TFLite metadata buffers.

Where a network may be asked: the region its training data covered.

Inside it the error bound of the file's metadata holds; outside a network answers
smoothly and wrongly, so a target there is refused.
"""

from __future__ import annotations

import hashlib
import json
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from deltactl.foundation.strict_yaml import StrictModel
from deltactl.models.robot import EffectEntry, FloatArray, Geometry, per_arm

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


METADATA_NAME = "deltactl"
"""Name of the TFLite metadata entry that carries the JSON."""

NO_CHECKSUM = "0" * 64
"""Placeholder for the checksum while it is computed."""

Degrees = Annotated[float, Field(ge=0.0)]
Count = Annotated[int, Field(ge=0)]


def fingerprint(geometry: Geometry) -> str:
    """16 hex digits that two geometries share when they move alike (to 1 nm and 1e-6 deg).

    Base and platform radius enter as their difference, the only thing the linkage sees.
    """
    numbers = {
        "radius_m": np.round(geometry.radius_m, 9),
        "upper_arm_m": np.round(per_arm(geometry.upper_arm_m), 9),
        "forearm_m": np.round(per_arm(geometry.forearm_m), 9),
        "azimuth_deg": np.round(np.mod(geometry.azimuth_deg, 360.0), 6),
        "home_offset_deg": np.round(np.asarray(geometry.home_offset_deg), 6),
    }
    # Adding 0.0 turns -0.0 into 0.0, which would print differently.
    plain = {name: (values + 0.0).tolist() for name, values in numbers.items()}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()[:16]


class TrainedRobot(StrictModel):
    """The robot a network was trained for."""

    name: str
    fingerprint: str
    """`fingerprint` of `geometry`."""
    geometry: Geometry
    effects: tuple[EffectEntry, ...] = ()
    """Those of the robot file's effects that its answers take into account."""


class Training(StrictModel):
    """Everything needed to train the same file again."""

    recipe: str
    seed: Count
    settings: dict[str, float | int | str] = Field(default_factory=dict)
    samples: Count
    """Labelled positions trained on."""
    source: str
    """Where the labels come from: geometry, or a data set."""
    data: str = ""
    """Digest of the data set."""
    machine: str = ""
    """The machine the data set was taken on: robot, simulated, or how a MuJoCo robot was built."""
    held_out: Count = 0
    """Samples of it that were kept from the training, to judge by."""
    versions: dict[str, str] = Field(default_factory=dict)
    """Versions of Python and of the libraries that did the arithmetic."""


class Validation(StrictModel):
    """Errors of the file as it runs (float32), against labels it was not trained on."""

    samples: Count
    rmse_deg: Degrees
    max_deg: Degrees
    bound_deg: Degrees | None = None
    """Holds wherever the network answers: half as much again as the largest error found, edges and
    hard corners included. None where only samples are known."""
    parity_deg: Degrees | None = None
    """Largest difference between the file as it runs and the same network in float64."""


class NetworkMetadata(StrictModel):
    """The whole record."""

    format: Literal[1] = 1
    written_by: str
    robot: TrainedRobot
    architecture: str
    parameters: Annotated[int, Field(ge=1)]
    domain: Domain
    angle_deg: Range
    """Lowest and highest angle trained on; an answer outside them is refused."""
    training: Training
    validation: Validation
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] = NO_CHECKSUM
    """Checksum of the whole file with these 64 digits replaced by zeros."""
