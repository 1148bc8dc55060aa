"""What was found on sister machines sharpens what one recording says.

The engine weighs each cause with odds that hold for any machine (`EffectKind.odds`). In a fleet
more is known: on how many sisters an effect lasts. A share of the sisters, drawn towards the
engine's own odds as by `WORTH` more machines (the mean of a beta distribution), takes the place of
those odds, and the probabilities of a finding and its alternatives follow by Bayes' rule. A robot
never counts as its own sister, so its recordings cannot talk themselves into anything.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from deltactl.fleet.book import Row
from deltactl.models.effects import VOCABULARY

WORTH = 4.0
"""The engine's odds count like so many machines."""
USUAL_ODDS = 0.02
"""Of an effect that no vocabulary has."""
LASTING, FEWEST = 0.5, 3
"""An effect lasts on a machine that has it in half of its recordings, of three at least."""
MOST = 0.999
"""No share of a fleet makes anything certain."""

Kind = tuple[str, str]
"""Effect, and component without its number."""


@dataclass(frozen=True)
class Sisters:
    """What is known of the other machines of a fleet."""

    machines: Mapping[Kind, int]
    """On how many machines each effect lasts."""
    lasts_on: Mapping[str, frozenset[Kind]]
    """What lasts on each machine that has recordings enough."""

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Sisters:
        """Count over the answers of a fleet."""
        runs: dict[str, int] = defaultdict(int)
        found: dict[tuple[str, Kind], int] = defaultdict(int)
        for row in rows:
            if "error" in row:
                continue
            runs[row["robot"]] += 1
            for kind in {_kind(one) for one in row["findings"]}:
                found[row["robot"], kind] += 1
        lasts_on = {
            robot: frozenset(
                kind for (of, kind), times in found.items()
                if of == robot and times >= LASTING * count
            )
            for robot, count in runs.items()
            if count >= FEWEST
        }  # fmt: skip
        machines: dict[Kind, int] = defaultdict(int)
        for kinds in lasts_on.values():
            for kind in kinds:
                machines[kind] += 1
        return cls(dict(machines), lasts_on)

    def having(self, robot: str, kind: Kind) -> tuple[int, int]:
        """On how many sisters of a robot an effect lasts, and how many sisters there are."""
        own = self.lasts_on.get(robot)
        having = self.machines.get(kind, 0) - (own is not None and kind in own)
        return having, len(self.lasts_on) - (own is not None)

    def ratio(self, robot: str, kind: Kind) -> float:
        """Odds that a sister has an effect, over those the engine took."""
        having, sisters = self.having(robot, kind)
        taken = VOCABULARY[kind[0]].odds if kind[0] in VOCABULARY else USUAL_ODDS
        share = (having + WORTH * taken / (1.0 + taken)) / (sisters + WORTH)
        return share / (1.0 - share) / taken


def sharpened(rows: Sequence[Row]) -> list[Row]:
    """The same answers with probabilities that count the sisters; what was said alone is kept.

    Each size of a finding gains `alone` (its probability by itself), `sisters` (in words) and
    `rather` (what the sisters make more likely than it, or nothing).
    """
    known = Sisters.of(rows)
    return [
        row if "error" in row else
        row | {"findings": [_sharper(known, row["robot"], one) for one in row["findings"]]}
        for row in rows
    ]  # fmt: skip


def _sharper(known: Sisters, robot: str, size: Row) -> Row:
    alone = size.get("probability")
    if alone is None:
        return size
    its = _kind(size)
    rivals = [one for one in size.get("alternatives", ()) if one["probability"] is not None]
    weights = [alone * known.ratio(robot, its)]
    weights += [one["probability"] * known.ratio(robot, _kind(one)) for one in rivals]
    neither = max(0.0, 1.0 - alone - sum(one["probability"] for one in rivals))
    total = sum(weights) + neither
    best = max(range(len(weights)), key=weights.__getitem__)
    rather = rivals[best - 1] if best else None
    having, sisters = known.having(robot, its)
    return size | {
        "alone": alone,
        "probability": min(MOST, weights[0] / total) if total > 0.0 else alone,
        "sisters": f"lasts on {having} of {sisters} sisters",
        "rather": f"{rather['effect']} at {rather['component']}" if rather else None,
    }


def _kind(size: Row) -> Kind:
    return size["effect"], re.sub(r"\d+$", "", size["component"])
