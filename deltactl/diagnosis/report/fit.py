"""Before and after the findings against the noise floor: sentences, and bars in HTML."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from deltactl.diagnosis.answer.records import Diagnosis, Fit
from deltactl.diagnosis.answer.verdict import goes_on, too_little
from deltactl.diagnosis.answer.what_is_left import (
    doubtful_floor,
    gone,
    left_by_file,
    moves_at_rest,
    once,
)
from deltactl.diagnosis.report.names import all_followed, listed, part, percent
from deltactl.diagnosis.report.sizes import forced, number, quantity, significant
from deltactl.diagnosis.report.templates import say


def fit_title(diagnosis: Diagnosis) -> str:
    """Heading of the figures of the fit."""
    return say("fit.title_found" if diagnosis.findings else "fit.title")


def fit_line(diagnosis: Diagnosis) -> str:
    """The error before and after, the noise, and the same on held-out data, in one sentence."""
    fit, found = diagnosis.fit, bool(diagnosis.findings)
    noise = "" if doubtful_floor(fit) else say("fit.noise", floor=_shown(fit, fit.noise_floor_m))
    held = _held(diagnosis) if found else ""
    if not found and fit.holdout == "run" and math.isfinite(fit.holdout_rms_before_m):
        held = say("fit.elsewhere", size=_shown(fit, fit.holdout_rms_before_m))
    before, after = (_shown(fit, m) for m in (fit.rms_before_m, fit.rms_after_m))
    case = "found" if found or diagnosis.loosely_built else "nothing"
    return say(f"fit.{case}", before=before, after=after, noise=noise, held=held)


def _held(diagnosis: Diagnosis) -> str:
    fit = diagnosis.fit
    sizes = (fit.holdout_rms_before_m, fit.holdout_rms_after_m)
    if not all(map(math.isfinite, sizes)):
        return say("fit.nothing_held_out")
    before, after = (_shown(fit, m) for m in sizes)
    where = say("fit.run" if fit.holdout == "run" else "fit.blocks")
    return say("fit.held", where=where, before=before, after=after, gain=_gain(diagnosis))


def _gain(diagnosis: Diagnosis) -> str:
    """How much of the held-out error is gone, in brackets; empty where that is not known."""
    fit, share = diagnosis.fit, gone(diagnosis)
    if fit.holdout == "run" and once(diagnosis):
        return say("gain.once")
    at_floor = _shown(fit, fit.holdout_rms_before_m) == _shown(fit, fit.noise_floor_m)
    if fit.holdout_rms_after_m > fit.holdout_rms_before_m:
        return say("gain.none")
    if math.isnan(share) or at_floor:
        return ""
    of = say("gain.all" if doubtful_floor(fit) else "gain.above_noise")
    return say("gain.share", share=percent(share), of=of)


def _shown(fit: Fit, size_m: float | None, digits: int = 3) -> str:
    return quantity(math.nan if size_m is None else size_m, fit.unit, digits=digits)


def unexplained(answer: Diagnosis) -> str:
    """What no finding explains, in one sentence."""
    fit, rest = answer.fit, answer.unexplained
    beyond = bool(rest.depends_on) or rest.share_of_mismatch > 0.0
    case = "follows" if rest.depends_on else "more" if beyond else "noise"
    if case == "noise" and doubtful_floor(fit):
        case = "by_file" if left_by_file(fit) else "unclear"
    little = beyond and too_little(fit, rest.share_of_mismatch, bool(answer.findings))
    return say(
        f"left.{case}",
        size=_shown(fit, fit.rms_after_m, 2),
        follows=all_followed(rest.depends_on),
        at=say("left.at", part=part(rest.component)) if rest.component else "",
        little=say("left.little") if little else "",
        figures="" if case == "noise" else say_all(figures(fit)),
    )


def say_all(facts: Iterator[str]) -> str:
    """': a, b and c'; empty where there are none."""
    shown = listed(list(facts))
    return f": {shown}" if shown else ""


def figures(fit: Fit) -> Iterator[str]:
    """What is known of the remaining error: how long it lasts, and where it is how large."""
    if goes_on(fit):
        times_s = (fit.left_lasts_s or math.nan, fit.left_apart_s or math.nan)
        lasts, apart = (quantity(time_s, "s", digits=2) for time_s in times_s)
        yield say("left.lasts", lasts=lasts, apart=apart)
    if fit.at_rest is not None and moves_at_rest(fit):
        by = _shown(fit, fit.at_rest.moved_by_m, 2)
        yield say("left.moves", by=by, moved=fit.at_rest.moved, rests=fit.at_rest.rests)
    elif fit.at_rest is not None:
        rest, motion = (
            _shown(fit, m, 2) for m in (fit.at_rest.left_m, fit.at_rest.left_in_motion_m)
        )
        yield say("left.in_motion", rest=rest, motion=motion)
    if fit.scatter_within_m is not None:
        yield say("left.scatter", size=_shown(fit, fit.scatter_within_m, 2))


def more_of_the_fit(fit: Fit) -> list[str]:
    """What else the figures of the fit are of: efforts after a filter."""
    if not forced(fit.unit) or fit.left_apart_s is None:
        return []
    return [say("fit.filtered", apart=quantity(fit.left_apart_s, "s", digits=2))]


@dataclass(frozen=True, slots=True)
class Pair:
    """Two bars of one thing: before and after the findings (NaN: there are none)."""

    name: str
    before: float
    after: float


def pair_bars(title: str, pairs: Iterable[Pair], noise: float, unit: str, note: str = "") -> str:
    """Bars before and after, with the noise floor as a line through all of them."""
    pairs = list(pairs)
    values = [x for pair in pairs for x in (pair.before, pair.after)] + [noise]
    top = max([x for x in values if math.isfinite(x)], default=1.0) or 1.0
    least = min([x for x in values[:-1] if math.isfinite(x) and x > 0.0], default=top)
    digits = max(0, significant(top, 3), significant(least, 2))
    rows = "".join(_pair(pair, noise, top, unit, digits) for pair in pairs)
    key = f'<span class="was">{say("bar.robot_file")}</span>'
    if any(math.isfinite(pair.after) for pair in pairs):
        key += f'<span class="became">{say("bar.with_findings")}</span>'
    key += f'<span class="noise">{say("bar.noise_floor")}</span>' if math.isfinite(noise) else ""
    caption = f"<figcaption>{html.escape(title)}</figcaption>" if title else ""
    foot = f'<p class="note">{html.escape(note)}</p>' if note else ""
    return f'<figure class="pairs">{caption}<p class="key note">{key}</p>{rows}{foot}</figure>'


def _pair(pair: Pair, noise: float, top: float, unit: str, digits: int) -> str:
    def width(value: float) -> float:
        return 100.0 * min(max(value, 0.0) / top, 1.0) if math.isfinite(value) else 0.0

    after = f" \u2192 {number(pair.after, digits)}" if math.isfinite(pair.after) else ""
    text = f"{number(pair.before, digits)}{after} {unit}"
    line = f'<b style="left:{width(noise):.2f}%"></b>' if math.isfinite(noise) else ""
    return (
        f'<div class="pair"><span>{html.escape(pair.name)}</span><div>'
        f'<i class="was" style="width:{width(pair.before):.2f}%"></i>'
        f'<i class="became" style="width:{width(pair.after):.2f}%"></i>{line}</div>'
        f"<span>{html.escape(text)}</span></div>"
    )
