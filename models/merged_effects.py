"""New findings, merged with the effects of the robot file: one entry an effect and component."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from deltactl.models.effects import VOCABULARY, Rule, card_of, effect_kind
from deltactl.models.effects.chain_poses import pose_effects
from deltactl.models.effects.kind import EffectKind
from deltactl.models.effects.tables import looked_up
from deltactl.models.robot import EffectEntry, FoundBy

Number = float | tuple[float, ...]
SAME_PERIOD = 0.02
"""Share by which two periods may differ and be called one."""


def merged(
    accepted: Iterable[EffectEntry], found: Iterable[EffectEntry]
) -> tuple[EffectEntry, ...]:
    """The effects of both: `found` is what acts beyond those of `accepted`.

    A size that is found again replaces the accepted one, with the sum of both.
    """
    entries = list(accepted)
    for new in found:
        place = next((i for i, old in enumerate(entries) if _is_again(old, new)), None)
        if place is None:
            entries.append(new)
        else:
            entries[place] = together(entries[place], new)
    return tuple(entries)


def together(old: EffectEntry, new: EffectEntry) -> EffectEntry:
    """One entry that does what both do one after the other (see `Rule`)."""
    card = card_of(new.effect)
    rule = card.rule
    before, after = _filled(old), _filled(new)
    # What little is left says little about the other parameters: the accepted ones stay.
    values = before | after if rule is Rule.NEWEST else after | before
    main = _kind(new.effect).main.name
    if rule is Rule.SUM:
        values[main] = _sum(before[main], after[main])
    elif rule is Rule.EACH:
        values = {n: _sum(before.get(n, 0.0), after.get(n, 0.0)) for n in before | after}
    elif rule is Rule.PRODUCT:
        values[main] = _one(before[main]) * _one(after[main])
    elif rule is Rule.SERIES:
        values[main] = 1.0 / (1.0 / _one(before[main]) + 1.0 / _one(after[main]))
    elif rule is Rule.RATE:
        k, beside = _one(before["stiffness"]), _one(after["stiffness"])
        values[main] = _one(before[main]) + _one(after[main]) * k / beside
        values["stiffness"] = k
    elif rule is Rule.PHASOR:
        values |= _phasor(before, after)
    elif rule is Rule.TABLE:
        values |= _table(before, after)
    if card.also_added:
        also = card.also_added
        values[also] = _sum(before[also], after[also])
    return EffectEntry(
        effect=new.effect,
        component=new.component,
        parameters=values,
        found=_moved(new.found, after, values),
    )


def _is_again(old: EffectEntry, new: EffectEntry) -> bool:
    if (old.effect, old.component) != (new.effect, new.component):
        return False
    rule = card_of(new.effect).rule
    if rule is Rule.TABLE:
        same = ("follows", "direction")
        return all(old.parameters.get(name) == new.parameters.get(name) for name in same)
    if rule is not Rule.PHASOR:
        return True
    one, other = _one(_filled(old)["period"]), _one(_filled(new)["period"])
    return abs(one - other) <= SAME_PERIOD * one


def _kind(name: str) -> EffectKind:
    """An effect of the vocabulary, or of a chain's poses alone. Raises ConfigError."""
    return (
        effect_kind(name) if name in VOCABULARY else pose_effects({}).get(name) or effect_kind(name)
    )


def _filled(entry: EffectEntry) -> dict[str, Number]:
    """Parameters with the defaults of the vocabulary."""
    kind = _kind(entry.effect)
    given = {p.name: p.default for p in kind.parameters if p.default is not None}
    # A file cannot say infinity; it leaves out what has it for a default.
    finite = {name: value for name, value in given.items() if np.isfinite(value)}
    return {**finite, **entry.parameters}


def _phasor(before: dict[str, Number], after: dict[str, Number]) -> dict[str, Number]:
    found: dict[str, Number] = {"period": before["period"]}
    for harmonic in ("", "_2"):
        amplitude, phase = f"amplitude{harmonic}", f"phase{harmonic}"
        waves = [wave for wave in (before, after) if amplitude in wave]
        total = sum(_one(w[amplitude]) * np.exp(1j * _one(w.get(phase, 0.0))) for w in waves)
        if waves:
            found |= {amplitude: float(abs(total)), phase: float(np.angle(total))}
    return found


def _table(before: dict[str, Number], after: dict[str, Number]) -> dict[str, Number]:
    both = [{name: np.asarray(value) for name, value in table.items()} for table in (before, after)]
    low = min(_one(before["lowest"]), _one(after["lowest"]))
    high = max(_one(before["highest"]), _one(after["highest"]))
    count = max(len(table["error"]) for table in both)
    places = np.linspace(low, high, count)
    total = sum(looked_up(table, places) for table in both)
    return {"error": tuple(np.asarray(total).tolist()), "lowest": low, "highest": high}


def _moved(
    found: FoundBy | None, alone: dict[str, Number], total: dict[str, Number]
) -> FoundBy | None:
    """Intervals of what was found, about the sizes that both amount to, and how they spread."""
    if found is None:
        return None
    kept = {}
    for name, interval in found.ci95.items():
        value, now = alone.get(name), total.get(name)
        if isinstance(value, float) and isinstance(now, float) and isinstance(interval[0], float):
            low, high = (float(np.ravel(end)[0]) for end in interval)
            kept[name] = (now + low - value, now + high - value)
    spread = {name: row for name, row in found.spread.items() if name in kept}
    return found.model_copy(update={"ci95": kept, "spread": spread})


def _sum(one: Number, other: Number) -> Number:
    total = np.asarray(one, dtype=np.float64) + np.asarray(other, dtype=np.float64)
    return float(total) if total.ndim == 0 else tuple(total.tolist())


def _one(value: Number) -> float:
    return float(np.asarray(value))
