"""The robots that the linkage is tried on, sound and crooked."""

from __future__ import annotations

from typing import Any

import pytest

from deltactl.models.linkage import Linkage
from deltactl.models.robot import Geometry

ZHAO: dict[str, Any] = {
    "base_radius_m": 0.325,
    "platform_radius_m": 0.075,
    "upper_arm_m": 0.25,
    "forearm_m": 0.5,
}
UZUNOVIC: dict[str, Any] = {
    "base_radius_m": 0.040,
    "platform_radius_m": 0.030,
    "upper_arm_m": 0.040,
    "forearm_m": 0.068,
}
CROOKED: dict[str, Any] = {
    "azimuth_deg": (3.0, 117.0, 244.5),
    "home_offset_deg": (1.5, -2.0, 0.7),
}

GEOMETRIES = {
    "zhao": Geometry(**ZHAO),
    "uzunovic": Geometry(**UZUNOVIC),
    "crooked-zhao": Geometry(
        **{**ZHAO, **CROOKED, "upper_arm_m": (0.25, 0.243, 0.258), "forearm_m": (0.49, 0.5, 0.512)}
    ),
    "crooked-uzunovic": Geometry(
        **{
            **UZUNOVIC,
            **CROOKED,
            "base_radius_m": (0.04, 0.042, 0.0385),
            "upper_arm_m": (0.0395, 0.04, 0.0412),
        }
    ),
    "clockwise-zhao": Geometry(**ZHAO, azimuth_deg=(0.0, 240.0, 120.0)),
}


@pytest.fixture(params=list(GEOMETRIES))
def geometry(request: pytest.FixtureRequest) -> Geometry:
    """One robot's geometry."""
    return GEOMETRIES[request.param]


@pytest.fixture
def linkage(geometry: Geometry) -> Linkage:
    """The same robot's linkage."""
    return Linkage.of(geometry)


@pytest.fixture
def zhao() -> Linkage:
    """The robot of Zhao 2023."""
    return Linkage.of(GEOMETRIES["zhao"])


@pytest.fixture
def uzunovic() -> Linkage:
    """The robot of Uzunovic 2013."""
    return Linkage.of(GEOMETRIES["uzunovic"])
