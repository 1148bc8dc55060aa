"""Before and after the findings against the noise floor, and what is left, in sentences."""

from __future__ import annotations

import math

from deltactl.diagnosis.answer.records import Diagnosis, Finding, Fit
from deltactl.diagnosis.answer.verdict import NAMELESS, goes_on, seen
from deltactl.diagnosis.answer.what_is_left import (
    beyond_noise_m,
    by_place_beside,
    doubtful_floor,
    held_out_gain,
    kind_of_rest,
    least_scatter_m,
    times_floor,
    told_of_rest,
    where_left,
    without,
)
from deltactl.diagnosis.report.names import all_followed, by_noise, part, sentence
from deltactl.diagnosis.report.sizes import forced, quantity
from deltactl.diagnosis.report.templates import say
from deltactl.models.effects import Trait, has


def fit_title(diagnosis: Diagnosis) -> str:
    """Heading of the figures of the fit."""
    return say("fit.title_found" if diagnosis.findings else "fit.title")


def fit_lines(diagnosis: Diagnosis) -> list[str]:
    """Before and after against the noise floor, on this recording and on held-out data."""
    fit, found = diagnosis.fit, bool(diagnosis.findings)
    before, after, floor = (
        quantity(size, fit.unit, digits=3)
        for size in (fit.rms_before_m, fit.rms_after_m, fit.noise_floor_m)
    )
    # A doubtful floor depends on what else was fitted: another file would have another.
    floor = "" if doubtful_floor(fit) else say("fit.floor", floor=floor)
    case = "found" if found else "allowed" if diagnosis.loosely_built else "mismatch"
    if diagnosis.verdict == "unexplained" and not found:
        case, floor = "mismatch", ""
    return [
        say(f"fit.{case}", before=before, after=after, floor=floor),
        *_beside(diagnosis),
        *(_held_out(diagnosis) if found else _elsewhere(fit)),
        *(say("fit.held_out_left_out", why=why) for why in diagnosis.not_held_out),
    ]


def _beside(diagnosis: Diagnosis) -> list[str]:
    """That efforts were compared after a filter, which single readings were not, and that most of
    what counts as noise does not show in readings at one place.
    """
    fit, lines = diagnosis.fit, []
    if forced(fit.unit) and fit.left_apart_s is not None:
        lines.append(say("fit.filtered", apart=quantity(fit.left_apart_s, "s", digits=2)))
    if by_place_beside(diagnosis):
        what = say("left.what_is_left" if doubtful_floor(fit) else "left.this_noise")
        where, more = _where_left(fit, what), _record_more(fit)
        lines.append(say("fit.by_place", scatter=_scatter(fit, 3), where=where, more=more))
    return lines


def _held_out(diagnosis: Diagnosis) -> list[str]:
    fit = diagnosis.fit
    held = (fit.holdout_rms_before_m, fit.holdout_rms_after_m)
    if not all(math.isfinite(value) for value in held):
        return [say("fit.nothing_held_out")]
    before, after = (quantity(value, fit.unit, digits=3) for value in held)
    where = say("fit.run" if fit.holdout == "run" else "fit.blocks")
    return [say("fit.held_out", where=where, before=before, after=after, gain=gain(diagnosis))]


def gain(diagnosis: Diagnosis) -> str:
    """How much of the held-out mismatch is gone, in brackets; empty where that is not known."""
    case, share = held_out_gain(diagnosis)
    of = say("gain.all" if doubtful_floor(diagnosis.fit) else "gain.above_noise")
    return say(f"gain.{case}", of=of, percent=f"{100.0 * share:.0f}")


def _elsewhere(fit: Fit) -> list[str]:
    """The mismatch on another run, where nothing was found."""
    size = fit.holdout_rms_before_m
    if fit.holdout != "run" or not math.isfinite(size):
        return []
    return [say("fit.elsewhere", size=quantity(size, fit.unit, digits=3))]


def share_line(finding: Finding, fit: Fit) -> str:
    """The mismatch if it alone were left out: what the other findings cannot take over."""
    compared = without(finding, fit)
    about = say("share.about") if compared.about else ""
    what = say("share.beyond" if compared.beyond else "share.mismatch")
    sizes = (compared.without_m, compared.with_m)
    missing, there = (quantity(size, fit.unit, digits=3) for size in sizes)
    case = "instead"
    if missing == there:
        case = "same"
    elif compared.smaller:
        case = "no_larger"
    elif compared.next_to_none:
        case = "none"
    else:
        missing = without_unit_of(missing, there)
    says = say(f"share.{case}", what=what, about=about, without=missing, after=there)
    return say(f"share.part_{compared.part}", compared=says)


def without_unit_of(size: str, other: str) -> str:
    """A size that is followed by another in the same unit."""
    return size.removesuffix(f" {other.partition(' ')[2]}")


def unexplained(answer: Diagnosis) -> str:
    """What no finding explains, in one sentence."""
    case, fit, rest = kind_of_rest(answer), answer.fit, answer.unexplained
    if case == "more":
        how = [by_noise(rest.p)] if rest.p is not None and seen(rest.p) else []
        times = times_floor(fit)
        how += [say("left.times_floor", times=times)] if times is not None else []
        told = f" ({', '.join(how)})" if how else ""
        if rest.depends_on:
            place = say("left.at", part=part(rest.component)) if rest.component else ""
            follows = all_followed(rest.depends_on)
            return say("left.more_follows", how=told, follows=follows, place=place)
        return say("left.more", how=told, goes_on=f"; {_persists(fit)}" if goes_on(fit) else "")
    nameless = any(one.effect == NAMELESS for one in answer.findings)
    play = any(has(one.effect, Trait.HYSTERESIS) for one in answer.findings)
    values = {
        "head": say("left.head_beside" if nameless else "left.head"),
        "size": quantity(fit.rms_after_m, fit.unit, digits=2),
        "moves": _moves(fit, play) if case == "moves" else "",
        "lasts": quantity(fit.left_lasts_s or math.nan, "s", digits=2),
        "persists": _persists(fit),
        "scatter": _scatter(fit, 2),
        "where": _where_left(fit, "it"),
        "record_more": _record_more(fit),
    }
    return say(f"left.{case}", **values)


def _moves(fit: Fit, found_play: bool) -> str:
    """That an axis moves while its command is constant, and what that calls for.

    found_play: whether play or friction was found all the same.
    """
    found = fit.at_rest
    assert found is not None
    by = quantity(found.moved_by_m, fit.unit, digits=2)
    case = "load_known" if found.load_known else "no_load" if found_play else "hidden"
    why = say(f"at_rest.{case}")
    return say("at_rest.moves", by=by, moved=found.moved, rests=found.rests, why=why)


def _scatter(fit: Fit, digits: int) -> str:
    """How much readings at one place scatter; of next to nothing, that it is little."""
    if (least_m := least_scatter_m(fit)) is not None:
        return say("left.scatter_below", size=quantity(least_m, fit.unit, digits=1))
    return say("left.scatter", size=quantity(fit.scatter_within_m or 0.0, fit.unit, digits=digits))


def _persists(fit: Fit) -> str:
    """That what is left is much the same from one reading to the next, as a clause."""
    lasts, apart = (
        quantity(time_s or math.nan, "s", digits=2)
        for time_s in (fit.left_lasts_s, fit.left_apart_s)
    )
    return say("left.persists", lasts=lasts, apart=apart)


def _where_left(fit: Fit, what: str) -> str:
    """Where most of it lies: in motion, or from place to place; `what` begins the clause."""
    rest = fit.at_rest
    sizes = (rest.left_m, rest.left_in_motion_m) if rest is not None else (0.0, 0.0)
    still, moving = (quantity(size, fit.unit, digits=2) for size in sizes)
    return say(f"where_left.{where_left(fit)}", what=what, rest=still, motion=moving)


def _record_more(fit: Fit) -> str:
    """What makes an answer surer where longer stays do not."""
    return say("left.more_places" if fit.at_rest is None else "left.more_moves")


def unexplained_line(diagnosis: Diagnosis) -> str:
    """What no finding explains; its size only where it is more than noise."""
    rest, fit, case = diagnosis.unexplained, diagnosis.fit, told_of_rest(diagnosis)
    says, follows = sentence(rest.says), all_followed(rest.depends_on)
    beyond_m = beyond_noise_m(fit.rms_after_m, fit.noise_floor_m)
    size = quantity(beyond_m, fit.unit, digits=2)
    if case == "beside_known":
        known = quantity(fit.done_by_known_m, fit.unit, digits=2)
        return say("rest.beside_known", left=size, known=known, little=say("rest.little"))
    if case == "too_little":
        what = say("rest.which_follows", follows=follows) if follows else ""
        return say("rest.too_little", size=size, little=say("rest.little"), follows=what)
    head = say("rest.size", size=size) if case == "sized" else ""
    more = sentence(say("rest.follows", follows=follows)) if follows and not says else ""
    return " ".join(filter(None, (head, says, more)))
