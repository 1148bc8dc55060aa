"""Whether a tie was admitted, and settled by the run that the answer proposed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from deltactl.proof.prove.table import Row, portion

Name = tuple[str, str]


@dataclass(frozen=True)
class TieScore:
    """`admitted`: the first answer offers both. `settled`: the last one holds to the truth."""

    pair: str
    settleable: bool
    proposed: bool
    admitted: bool
    settled: bool
    told: bool
    """Some answer says which measurement would settle what no motion can."""


def score_tie(result: dict[str, Any]) -> TieScore:
    """Score what `run_tie` returned.

    Where no motion can settle a pair, to admit the tie is all that can be right.
    """
    truth = {(line["effect"], line["where"]) for line in result["truth"]["answers"]}
    rival = {(effect, where) for effect, where in result["rival"]}
    named, offered = _names(result["first"])
    admitted = bool(truth & offered) and bool(rival & offered)
    proposed = result["proposed"] is not None
    told = any(_open(result[n]) for n in ("first", "second"))
    if not result["settleable"]:
        return TieScore(result["pair"], False, proposed, admitted, admitted, told)
    if proposed:
        named, offered = _names(result["second"])
    settled = truth <= named and not rival & offered
    return TieScore(result["pair"], True, proposed, admitted, settled, told)


def _open(answer: dict[str, Any] | None) -> bool:
    """Whether an answer names a pair that needs a measurement by hand."""
    return answer is not None and bool(answer.get("open_ties"))


def _names(answer: dict[str, Any] | None) -> tuple[set[Name], set[Name]]:
    """Names of the findings; and with their alternatives."""
    found = [] if answer is None else answer["findings"]
    named = {(f["effect"], f["component"]) for f in found}
    others = {(a["effect"], a["component"]) for f in found for a in f["alternatives"]}
    return named, named | others


def tie_rows(scores: Sequence[TieScore]) -> list[Row]:
    """Rows for the table."""
    pairs = sorted({s.pair for s in scores})
    can = [s for s in scores if s.settleable]
    return [
        portion("ties: settled after the proposed run", [s.settled for s in can], 0.90),
        portion("... where a run was proposed", [s.settled for s in can if s.proposed]),
        portion("... where the first answer alone was to decide",
                [s.settled for s in can if not s.proposed]),
        portion("... the first answer offered both", [s.admitted for s in scores]),
        portion("... a run was proposed", [s.proposed for s in can]),
        portion("... no motion can settle: says which measurement",
                [s.told for s in scores if not s.settleable]),
        *(portion(f"... {p}", [s.settled for s in scores if s.pair == p]) for p in pairs),
    ]  # fmt: skip
