"""Defects that the simulated robot of the page can conceal, for a diagnosis to find.

What is chosen is written where only the simulated daemon reads it; recordings and the processes
that diagnose them never see it.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.plain_file import write_whole
from deltactl.models.effects import CARDS, EffectCard
from deltactl.models.effects.card import Defect
from deltactl.models.robot import per_arm

Entry = dict[str, Any]
NOTHING = "nothing"
SURPRISE = "a surprise"


def defects() -> dict[str, Callable[[RobotFile], Entry]]:
    """What the cards offer to hide, in words, and its entry of `effects` in a robot."""
    offered = [(card.defect, card) for card in CARDS.values() if card.defect]
    offered.sort(key=lambda pair: pair[0].listed)
    return {defect.text: partial(_entry, card, defect) for defect, card in offered}


def _entry(card: EffectCard, defect: Defect, robot: RobotFile) -> Entry:
    unit = 1.0
    if card.length:
        lengths_m = per_arm(getattr(robot.geometry, card.length))
        unit = float(lengths_m[int(defect.component[-1]) - 1])
    parameters = {name: size * unit for name, size in defect.parameters.items()}
    return {"effect": card.name, "component": defect.component, "parameters": parameters}


class Concealment:
    """One choice, for everybody who looks at the page."""

    def __init__(self, path: Path):
        """path: which the simulated daemon reads when it homes."""
        self._path = path
        self.chosen = NOTHING
        """As it was chosen: a surprise stays one."""
        self.really = NOTHING
        """Which defect that is."""

    @property
    def choices(self) -> list[str]:
        """What can be chosen."""
        return [NOTHING, SURPRISE, *defects()]

    def conceal(self, choice: str, robot: RobotFile) -> None:
        """Write the file anew. Raises KeyError for what is no choice."""
        drawn = secrets.choice(list(defects())) if choice == SURPRISE else choice
        if drawn == NOTHING:
            self._path.unlink(missing_ok=True)
        else:
            # The daemon reads all of it or the one before.
            write_whole(self._path, yaml.safe_dump({"effects": [defects()[drawn](robot)]}))
        self.chosen, self.really = choice, drawn
