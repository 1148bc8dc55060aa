"""Model errors without a name: Gaussian processes over a covariate, at a place of the machine.

A process has a kernel of Matern's class with nu = 5/2; its length and size are the most probable of
a grid (Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, sections 4.2 and 5.4).
One whose most probable size is none has nothing to say (automatic relevance determination). An
error that comes and goes in time (a table that sways, a lamp that flickers) would take so short a
length that it followed noise: a line in the spectrum of the residual has three numbers only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.sparse import csr_array, diags_array

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.model import (
    PLATFORM,
    DeltaModel,
    component_at,
    on_platform,
    own_place,
    sensible,
)
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import PROCESSES
from deltactl.diagnosis.plants.delta.point import end_to_end
from deltactl.diagnosis.plants.regressor import Columns

UNKNOWN = "unknown@"


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What enters at an input location and follows one covariate; knots: none of a wave."""

    entry: str
    covariate: str
    knots: FloatArray

    def hats(self, model: DeltaModel, two_way: bool, rate_hz: float = 0.0) -> csr_array:
        """Straight lines between knots (n, knots), or a wave (n, 2)."""
        if rate_hz:
            return _wave(model.readings.t_s, rate_hz)
        return _hats(model.covariates()[self.covariate], self.knots, two_way)


@dataclass(frozen=True, slots=True, eq=False)
class Process:
    """A process at a place of the machine, of one length and size in all its parts.

    two_way: changes sign with the way the covariate came. shapes: (knots, k) of the kernel, each in
    its prior standard deviation, one part after another. gain: log evidence that it adds. paid: for
    the choice of length and size. rate_hz: of a wave in time, which has no knots.
    """

    component: str
    parts: tuple[Part, ...]
    two_way: bool = False
    shapes: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    gain: float = 0.0
    paid: float = 0.0
    rate_hz: float = 0.0

    @property
    def follows(self) -> tuple[str, ...]:
        """Names of its covariates."""
        names = [name for part in self.parts for name in part.covariate.split(", ")]
        return tuple(dict.fromkeys(names))

    @property
    def single(self) -> Part | None:
        """Its part where it has one that follows a covariate one way."""
        return None if self.two_way or self.rate_hz or len(self.parts) > 1 else self.parts[0]

    @property
    def key(self) -> str:
        """Name among regressors."""
        ways = " two-way" if self.two_way else ""
        wave = " wave" if self.rate_hz else ""
        place = self.component if len(self.parts) > 1 else self.parts[0].entry
        return f"{UNKNOWN}{place} {', '.join(self.follows)}{ways}{wave}"

    def over(self, covariate: FloatArray) -> FloatArray:
        """Shapes (m, k) of its only part at values (m,) of the covariate."""
        (part,) = self.parts
        return np.asarray(_hats(covariate, part.knots, self.two_way) @ self.shapes)

    def entering(self, model: DeltaModel) -> dict[str, FloatArray]:
        """Shapes (n, k) by what they enter at."""
        found: dict[str, FloatArray] = {}
        first = 0
        for part in self.parts:
            hats = part.hats(model, self.two_way, self.rate_hz)
            own = np.asarray(hats @ self.shapes[first : first + hats.shape[1]])
            first += hats.shape[1]
            found[part.entry] = found.get(part.entry, 0.0) + own
        return found

    def columns(self, model: DeltaModel) -> Columns:
        """Its shapes in all channels (n c, k)."""
        inputs = model.inputs()
        each = [inputs[at][:, :, None] * own[:, None] for at, own in self.entering(model).items()]
        values = end_to_end(np.sum(each, axis=0))
        lasts = not self.rate_hz  # the phase is another one each time
        return Columns(values, np.ones(values.shape[1]), lasts=lasts)


Ways = tuple[Process, list[csr_array]]
"""A process without its shapes, and of each part the straight lines between knots (n, knots)."""


class Processes:
    """All processes that make sense on a machine."""

    def __init__(self, model: DeltaModel):
        self.model = model
        covariates = model.covariates()
        varying = {n: x for n, x in covariates.items() if np.ptp(x) > 1e-6 * np.abs(x).max()}
        knots = {n: _knots(x) for n, x in varying.items()}
        hats = {n: _hats(x, knots[n], False) for n, x in varying.items()}
        places = [at for at in model.inputs() if not at.startswith(PLATFORM)]
        found = []
        for at in places:
            own = [Part(at, name, knots[name]) for name in varying if sensible(at, name)]
            found += [Process(at, (part,)) for part in own]
            if own_place(at) in varying:
                found.append(Process(at, (Part(at, own_place(at), knots[own_place(at)]),), True))
        for pairs in on_platform(varying):
            parts = tuple(Part(at, name, knots[name]) for at, name in pairs)
            found.append(Process(component_at(PLATFORM), parts))
        self.every: list[Ways] = [
            (
                one,
                [
                    part.hats(model, True) if one.two_way else hats[part.covariate]
                    for part in one.parts
                ],
            )
            for one in found
        ]

    def __len__(self) -> int:
        return len(self.every) + len(self.model.inputs())

    def remembering(self, one: Process) -> list[Ways]:
        """Processes at a place over earlier values of a covariate, and over the way it came."""
        (part,) = one.parts
        t_s, now = self.model.readings.t_s, self.model.covariates()[part.covariate]
        pasts = [np.interp(t_s - late_s, t_s, now) for late_s in PROCESSES.past_s]
        found = [(one, [_hats(past, part.knots, False)]) for past in pasts]
        return [*found, (replace(one, two_way=True), [_hats(now, part.knots, True)])]

    def probable(
        self,
        noise: ChannelsNoise,
        left: FloatArray,
        free: FloatArray,
        among: Sequence[Ways] | None = None,
    ) -> list[Process]:
        """Each with its most probable length and size, those that gain nothing left out.

        left: (n c,) unexplained. free: whitened columns (m, p) in their spreads, fitted beside it.
        """
        taken, white = Absorbed(free), noise.whiten(left)
        of_left = taken.share(white)
        inputs = self.model.inputs()
        weight = diags_array(noise.scale * noise.sigma)
        operators = {n: csr_array(weight @ noise.whitener.at_input(x)) for n, x in inputs.items()}
        found = []
        if among is None:
            rest = white - free @ taken.sizes(white)
            among = [*self.every, *(w for n in inputs for w in self._waves(noise, rest, n))]
        seen = {n: (o.T @ free, o.T @ white) for n, o in operators.items()}
        powers = cache(lambda one, other: csr_array(operators[one].T @ operators[other]))
        for process, hats in among:
            pairs = list(zip((part.entry for part in process.parts), hats, strict=True))
            with_free = np.concatenate([own.T @ seen[at][0] for at, own in pairs])
            with_left = np.concatenate([own.T @ seen[at][1] for at, own in pairs])
            power = [[(a.T @ (powers(n, m) @ b)).toarray() for m, b in pairs] for n, a in pairs]
            share = taken.root_of(with_free.T)
            gram = np.block(power) - share.T @ share
            best = _most_probable(process, gram, with_left - share.T @ of_left)
            if best is not None:
                found.append(best)
        return sorted(found, key=lambda one: one.paid - one.gain)

    def _waves(self, noise: ChannelsNoise, rest: FloatArray, location: str) -> list[Ways]:
        """The wave that explains most of the residual (m,) at a place; the choice is paid for."""
        readings = self.model.readings
        channel, rows = np.divmod(noise.rows, len(readings.t_s))
        pull = self.model.inputs()[location][rows, channel] * noise.scale
        at = np.rint((readings.t_s[rows] - readings.t_s[0]) / readings.period_s).astype(np.intp)
        near = at - at.min() < PROCESSES.most_transformed
        series = np.bincount(at[near], (pull * rest)[near])
        size = int(2 ** np.ceil(np.log2(PROCESSES.finer * len(series))))
        first = int(np.ceil(PROCESSES.fewest_turns * size / len(series)))
        last = int(PROCESSES.fastest * size)
        if last <= first or not pull.any():
            return []
        lines = np.abs(np.fft.rfft(series, size)[first:last])
        # Between the lines, where a quarter of one already leaves a rest.
        turns = (first + int(np.argmax(lines)) + np.linspace(-1.0, 1.0, PROCESSES.between)) / size
        samples = -2j * np.pi * np.arange(len(series))
        best = max(turns.tolist(), key=lambda one: abs(np.exp(samples * one) @ series))
        rate_hz = best / readings.period_s
        paid = float(np.log(last - first))
        part = Part(location, "time", np.zeros(0))
        one = Process(component_at(location), (part,), paid=paid, rate_hz=rate_hz)
        return [(one, [_wave(readings.t_s, rate_hz)])]


def _wave(t_s: FloatArray, rate_hz: float) -> csr_array:
    """Sine and cosine (n, 2)."""
    turn = 2.0 * np.pi * rate_hz * t_s
    return csr_array(np.stack([np.sin(turn), np.cos(turn)], axis=1))


def _most_probable(process: Process, gram: FloatArray, along: FloatArray) -> Process | None:
    """The process with the length and size of most evidence; None where none has any."""
    gains: list[float] = []
    best: tuple[float, FloatArray] = (0.0, np.zeros((0, 0)))
    kernels = [np.eye(2)] if process.rate_hz else map(_kernel_shapes, PROCESSES.lengths)
    for one in kernels:
        shapes = block_diag(*[one] * len(process.parts))
        values, vectors = np.linalg.eigh(shapes.T @ gram @ shapes)
        values = np.maximum(values, 0.0)
        seen = (vectors.T @ (shapes.T @ along)) ** 2
        usual = float(np.sqrt(max(values.max(), 1e-300)))
        for ratio in PROCESSES.ratios:
            power = (ratio / usual) ** 2
            each = seen * power / (1.0 + power * values) - np.log1p(power * values)
            gain = 0.5 * float(each.sum())
            gains.append(gain)
            if gain > best[0]:
                seen_at_all = power * values > PROCESSES.least_chi2
                best = gain, shapes @ vectors[:, seen_at_all] * (ratio / usual)
    if best[0] <= 0.0:
        return None
    top = max(gains)
    paid = process.paid - float(np.log(np.mean(np.exp(np.array(gains) - top))))
    return replace(process, shapes=best[1], gain=best[0], paid=paid)


@cache
def _kernel_shapes(length: float) -> FloatArray:
    """Shapes (knots, k) of the kernel over knots, in standard deviations, for unit size."""
    at = np.linspace(0.0, 1.0, PROCESSES.knots)
    apart = np.sqrt(5.0) * np.abs(at[:, None] - at) / length
    kernel = (1.0 + apart + apart**2 / 3.0) * np.exp(-apart)
    values, vectors = np.linalg.eigh(kernel)
    own = values > PROCESSES.least_share * values.max()
    shapes: FloatArray = vectors[:, own] * np.sqrt(values[own])
    return shapes


def _knots(covariate: FloatArray) -> FloatArray:
    """Half-way between quantiles and equal steps, so that none spans an empty range."""
    share = np.linspace(0.0, 1.0, PROCESSES.knots)
    even = covariate.min() + np.ptp(covariate) * share
    inner = 0.5 * (np.quantile(covariate, share) + even)
    spaced: FloatArray = np.maximum.accumulate(inner + 1e-9 * np.ptp(covariate) * share)
    return spaced


def _hats(covariate: FloatArray, knots: FloatArray, two_way: bool) -> Any:
    """Linear interpolation between knots, (n, knots), constant beyond them."""
    inside = np.clip(covariate, knots[0], knots[-1])
    at = np.clip(np.searchsorted(knots, inside, side="right") - 1, 0, len(knots) - 2)
    part = (inside - knots[at]) / np.maximum(knots[at + 1] - knots[at], 1e-300)
    part = np.clip(part, 0.0, 1.0)
    sign = way(covariate) if two_way else np.ones(len(covariate))
    rows = np.arange(len(covariate))
    values = np.concatenate([sign * (1.0 - part), sign * part])
    places = np.concatenate([rows, rows]), np.concatenate([at, at + 1])
    return csr_array((values, places), shape=(len(covariate), len(knots)))


def way(covariate: FloatArray) -> FloatArray:
    """+1 or -1: which way the covariate last moved by more than a little; 0 before it did."""
    reach = PROCESSES.least_move * float(np.ptp(covariate))
    ways = np.zeros(len(covariate))
    anchor, last = float(covariate[0]), 0.0
    for k, value in enumerate(covariate.tolist()):
        if abs(value - anchor) > reach:
            last = 1.0 if value > anchor else -1.0
            anchor = value - last * reach
        ways[k] = last
    return ways
