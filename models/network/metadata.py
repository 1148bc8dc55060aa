"""What a network file says about itself, as JSON in one of its TFLite metadata buffers."""

from __future__ import annotations

import hashlib
import json
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from deltactl.foundation.strict_yaml import StrictModel
from deltactl.models.network.domain import Domain, Range
from deltactl.models.robot import EffectEntry, Geometry, per_arm

METADATA_NAME = "deltactl"
"""Name of the TFLite metadata entry that carries the JSON."""

FORMAT = 1
NO_CHECKSUM = "0" * 64
"""Stands in place of the checksum while the checksum is computed."""

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
    """Of Python and of the libraries that did the arithmetic."""


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
    """Of the whole file with these 64 digits replaced by zeros."""
