"""The fit of the whole library at once, and what it takes out of the noise that it is to show.

Hundreds of columns also follow the noise a little, its slow part most: what they leave has too
small a spread and too short a memory, and scores whitened by that come out too large. By how much
is seen on noise drawn from the estimate itself and treated in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from deltactl.diagnosis.evidence.autoregression import (
    AR_ORDER,
    ChannelNoise,
    Whitener,
    channels_of,
    stationary,
)
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, Readings


class SaturatedFit(Protocol):
    """A fit of many columns at once."""

    is_cut: bool
    readings: Readings

    def __call__(self, residual: FloatArray) -> FloatArray:
        """What it explains of residuals, (n, channels) or (n, channels, k)."""
        ...


def given_back(fit: SaturatedFit, left: Whitener) -> Whitener:
    """The noise of which a fit leaves what was seen, by its memory and its spread.

    left: what was estimated from the residual of the fit. Noise that is drawn, fitted and estimated
    must come out as `left`: what the fit takes from it depends on the noise, so it is tried until
    that holds (indirect inference: Gourieroux, Monfort and Renault 1993, J. Appl. Econometrics 8,
    S85-S118).
    """
    found = _before_the_fit(fit, left, left)
    for _ in range(EVIDENCE.given_back_rounds - 1):
        earlier = found.noise
        found = _before_the_fit(fit, left, earlier)
        if _change(earlier, found.noise) < EVIDENCE.settled:
            break
    pairs = zip(found.noise.channels, found.errors, strict=True)
    channels = tuple(_cautious(one, error, fit.is_cut) for one, error in pairs)
    return replace(found.noise, channels=channels)


@dataclass(frozen=True, slots=True, eq=False)
class _Before:
    """A noise, as it was before a fit took its part."""

    noise: Whitener
    errors: list[_Errors]


@dataclass(frozen=True, slots=True)
class _Errors:
    """Standard errors of one channel's noise."""

    memory: float
    """Spread of the sum of its coefficients."""
    sigma: float
    """Spread of the innovations' standard deviation, relative."""


def _cautious(noise: ChannelNoise, errors: _Errors, little_read: bool) -> ChannelNoise:
    """Memory that makes slow noise smaller than white noise needs evidence.

    A sensor averages, its readings do not alternate; and what is taken for alternation by mistake
    makes everything slow look like more than noise. Where little was read, memory and spread are
    taken a standard error larger than they look.
    """
    total = float(noise.phi.sum())
    if little_read:
        larger = min(max(total, 0.0) + errors.memory, max(total, EVIDENCE.longest_memory))
        sigma = noise.sigma * (1.0 + errors.sigma)
        return replace(noise, sigma=sigma, phi=noise.phi + (larger - total) / AR_ORDER)
    if total >= 0.0 or total < -EVIDENCE.alternates * errors.memory:
        return noise
    return replace(noise, phi=noise.phi - total / AR_ORDER)


def _before_the_fit(fit: SaturatedFit, left: Whitener, noise: Whitener) -> _Before:
    """What is left, with what the fit takes from draws of a noise given back to it."""
    readings = fit.readings
    rng = np.random.default_rng(EVIDENCE.noise_seed)
    draws = EVIDENCE.noise_draws
    drawn = np.stack([noise.drawn(rng, len(readings.t_s)) for _ in range(draws)], axis=2)
    remains = drawn - fit(drawn)

    def sized(residual: FloatArray) -> list[ChannelNoise]:
        """Without the rows, which are large and the same in all."""
        found, _ = channels_of(readings, [one.rows for one in left.channels], residual)
        return [replace(one, rows=one.rows[:0]) for one in found]

    each = [*np.moveaxis(drawn, 2, 0), *np.moveaxis(remains, 2, 0)]
    sizes = [sized(residual) for residual in each]
    before, after = sizes[:draws], sizes[draws:]
    channels, errors = [], []
    for number, own in enumerate(left.channels):
        pairs = [(b[number], a[number]) for b, a in zip(before, after, strict=True)]
        taken = np.mean([b.phi - a.phi for b, a in pairs], axis=0)
        louder = _ratio([(b.sigma, a.sigma) for b, a in pairs])
        wider = _ratio([(b.spread, a.spread) for b, a in pairs])
        share = _share(own.phi, taken)
        errors.append(_errors([a for _, a in pairs]))
        channels.append(
            replace(
                own,
                phi=stationary(own.phi + share * taken),
                sigma=own.sigma * louder,
                spread=own.spread * (louder + share * (wider - louder)),
            )
        )
    return _Before(Whitener(tuple(channels), left.weight), errors)


def _errors(drawn: Sequence[ChannelNoise]) -> _Errors:
    """From estimates of one channel's noise in draws of it."""
    sigmas = [one.sigma for one in drawn]
    memory = float(np.std([one.phi.sum() for one in drawn], ddof=1))
    return _Errors(memory, float(np.std(sigmas, ddof=1) / np.mean(sigmas)))


def _change(one: Whitener, other: Whitener) -> float:
    """Largest change of a coefficient of the noise's memory."""
    pairs = zip(one.channels, other.channels, strict=True)
    return max((float(np.abs(a.phi - b.phi).max()) for a, b in pairs), default=0.0)


def _ratio(pairs: list[tuple[float, float]]) -> float:
    before, after = np.mean(pairs, axis=0)
    return float(before / after) if after > 0.0 else 1.0


def _share(phi: FloatArray, taken: FloatArray) -> float:
    """How much of the memory that was taken may be given back, by `longest_memory`."""
    room, more = EVIDENCE.longest_memory - float(phi.sum()), float(taken.sum())
    return float(np.clip(room / more, 0.0, 1.0)) if more > 0.0 else 1.0
