"""Linkages as far off a robot file as a faulty machine may well be."""

from __future__ import annotations

from itertools import product

from deltactl.models.linkage.arms import Linkage

LENGTH_OFF = 0.02
"""Share of the forearm,"""
HOME_OFF_RAD = 0.02
"""and angle, by which a faulty machine may well be off; moderate faults are half as large."""


def neighbours(linkage: Linkage) -> list[Linkage]:
    """The four with all arms off alike."""
    return [
        linkage.with_(
            forearm_m=linkage.forearm_m * (1.0 + longer * LENGTH_OFF),
            home_offset_rad=linkage.home_offset_rad + further * HOME_OFF_RAD,
        )
        for longer, further in product((-1.0, 1.0), (-1.0, 1.0))
    ]
