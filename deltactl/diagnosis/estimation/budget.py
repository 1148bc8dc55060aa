"""Budget: how much work the search for causes may be before it ends with the best it has.

Counted in predictions of a whole recording, not in seconds: the same recording gives the same
answer on a fast machine and on a slow one, on one core and on two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from functools import partial
from math import inf
from typing import TypeVar

from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.estimation.side_by_side import side_by_side

Made = TypeVar("Made")


class Until(Enum):
    """Share of the work after which a part of the search is not begun any more.

    What tells named effects from build tolerances and from spline terms comes last, and is
    kept some: without it a pile of effects would be claimed.
    """

    CALMED = 0.4
    """The noise is taken once more, and the search goes on under it."""
    GROWN = 0.5
    """One more effect is looked for, and each of the others reconsidered beside it."""
    PAIRED = 0.55
    """Whether an effect only looks like two others, or several are a group."""
    REVIEWED = 0.75
    """Which of the effects are needed beside build tolerances."""
    SHAPED = 0.8
    """Spline terms other than the likeliest, and a second one."""
    TOLERANCES = 0.85
    """What else build tolerances need."""
    RESOLVED = 0.9
    """An alternative that turned out to be better takes the place of a finding."""


@dataclass(slots=True, eq=False)
class Budget:
    """Work that a search may be, and has been."""

    most: float = inf
    spent: float = 0.0
    ended: bool = False
    """Something was not begun any more."""

    @classmethod
    def for_rows(cls, rows: int) -> Budget:
        """That of a recording of so many rows; one that is longer takes longer."""
        return cls(ESTIMATION.predictions * max(1.0, ESTIMATION.rows_of_unit / rows))

    def spend(self, predictions: float = 1.0) -> None:
        """Count work."""
        self.spent += predictions

    @contextmanager
    def not_counted(self) -> Iterator[None]:
        """For what is remembered: which process already knows it must not make a difference."""
        spent = self.spent
        try:
            yield
        finally:
            self.spent = spent

    def lasts(self, until: Until) -> bool:
        """Whether a part of the search may still be begun."""
        lasts = self.spent < until.value * self.most
        self.ended = self.ended or not lasts
        return lasts

    def side_by_side(
        self, tasks: Sequence[Callable[[], Made]], known: Sequence[object] = ()
    ) -> list[Made]:
        """What tasks return, each begun with what is left now, whoever works on it and when."""
        found = side_by_side([partial(self._counted, task) for task in tasks], known)
        self.spent += sum(spent for _, spent, _ in found)
        self.ended = self.ended or any(ended for _, _, ended in found)
        return [made for made, _, _ in found]

    def _counted(self, task: Callable[[], Made]) -> tuple[Made, float, bool]:
        spent, ended = self.spent, self.ended
        made = task()
        counted = made, self.spent - spent, self.ended
        self.spent, self.ended = spent, ended
        return counted
