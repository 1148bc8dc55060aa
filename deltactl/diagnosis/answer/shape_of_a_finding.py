"""What a mechanic reads beside the size of a finding: waves, harmonics, loads and paces.

In: a finding, and the picture of the model error. Out: figures; None where there is nothing to
tell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.answer.options import SAYING
from deltactl.diagnosis.answer.picture import Channel, FloatArray, Picture, bare
from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.models.effects.lone_axis import COMPONENT


@dataclass(frozen=True, slots=True)
class Wave:
    """A wave over the travel: its period in `unit`, how many were recorded, the share it takes."""

    period: float
    unit: str
    waves: float
    share: float


def friction_without_load(finding: Finding) -> tuple[tuple[float, float, float], str] | None:
    """Friction that is there without the load that makes it larger, its interval, and its unit."""
    share = finding.parameters.get("unloaded")
    if share is None or share.components[0][0] > SAYING.unloaded_alike:
        return None
    width = finding.parameters["width"]
    alone, least, most = (part * width.components[0][0] for part in share.components[0])
    return (alone, least, most), width.unit


def second_harmonic(finding: Finding) -> tuple[float, float, str] | None:
    """Second wave of a periodic error of an axis that is no plain sine, the span of both together,
    and the unit.
    """
    sizes = {name: one.components[0][0] for name, one in finding.parameters.items()}
    first, second = sizes.get("amplitude", 0.0), sizes.get("amplitude_2", 0.0)
    if finding.component != COMPONENT or second <= SAYING.second_wave * first:
        return None
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    both = first * np.sin(turn + sizes.get("phase", 0.0))
    both += second * np.sin(2.0 * turn + sizes.get("phase_2", 0.0))
    return second, float(np.ptp(both)), finding.parameters["amplitude"].unit


def too_few_periods(finding: Finding, picture: Picture | None) -> Wave | None:
    """The one wave over the travel that takes away most of what an unknown of an axis does.

    A periodic error of which fewer than three periods were recorded is not named: a bend, or a
    drift, looks like one.
    """
    follows = [bare(name) for name in finding.depends_on[:1]]
    if picture is None or finding.effect != NAMELESS or finding.component != COMPONENT:
        return None
    place = {bare(name): values for name, values in picture.covariates.items()}
    channel = picture.channels[0]
    if "position" not in place or channel.unit not in ("m", "rad"):
        return None
    return _one_wave(place["position"], channel) if follows in (["time"], ["position"]) else None


def _one_wave(at: FloatArray, channel: Channel) -> Wave | None:
    """The wave over the travel that takes most of the power; None where none does.

    Of what was found by name at first, a constant and a line over the travel are no wave.
    """
    left = channel.observed - channel.before
    known = np.isfinite(left) & np.isfinite(at)
    if np.count_nonzero(known) < SAYING.wave_rows or not np.ptp(at[known]) > 0.0:
        return None
    span = float(np.ptp(at[known]))
    along, left = (at[known] - at[known].min()) / span, left[known]
    plain = np.stack([np.ones_like(along), along], axis=1)

    def power(waves: float) -> float:
        turn = 2.0 * np.pi * waves * along
        shapes = np.concatenate([plain, np.stack([np.sin(turn), np.cos(turn)], axis=1)], axis=1)
        return float(np.sum((left - shapes @ np.linalg.lstsq(shapes, left, rcond=None)[0]) ** 2))

    whole = float(np.sum((left - plain @ np.linalg.lstsq(plain, left, rcond=None)[0]) ** 2))
    tried = np.arange(SAYING.least_told_waves, SAYING.most_told_waves, 0.05)
    powers = [power(float(waves)) for waves in tried]
    best = int(np.argmin(powers))
    share = 1.0 - powers[best] / max(whole, 1e-300)
    if not 0 < best < len(tried) - 1 or share <= SAYING.wave_takes:
        return None
    return Wave(span / float(tried[best]), channel.unit, float(tried[best]), share)


def changes_its_pace(finding: Finding, picture: Picture | None) -> bool:
    """Whether an unknown follows the time of a motion that is faster in one part than in another.

    Parts in which the machine rests do not count.
    """
    follows = [bare(name) for name in finding.depends_on[:1]]
    if finding.effect != NAMELESS or follows not in (["time"], ["t"]) or picture is None:
        return False
    return any(
        _paces(values) > SAYING.other_pace
        for name, values in picture.covariates.items()
        if bare(name).startswith(("velocity", "speed")) and len(values) == len(picture.t_s)
    )


def _paces(speed: FloatArray) -> float:
    """How many times as fast the fastest part of a motion (n,) is as the slowest."""
    moves = np.nan_to_num(speed)[np.nan_to_num(speed) != 0.0]
    if len(moves) < SAYING.paces:
        return 1.0
    each = [float(np.sqrt(np.mean(part**2))) for part in np.array_split(moves, SAYING.paces)]
    return max(each) / max(min(each), 1e-300)


def period_takes_s(finding: Finding, picture: Picture | None, steady: float) -> float | None:
    """How long a period takes, where the axis goes at one speed; None where it does not.

    steady: correlation of the place with the time from which on it does.
    """
    period = finding.parameters.get("period")
    if period is None or picture is None or "position" not in picture.covariates:
        return None
    position, t_s = picture.covariates["position"], picture.t_s
    if abs(float(np.corrcoef(position, t_s)[0, 1])) < steady:
        return None
    return abs(period.components[0][0] / float(np.polyfit(t_s, position, 1)[0]))
