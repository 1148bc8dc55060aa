"""Model errors without a name: Gaussian processes over a covariate, at a place of the machine.

A process has a kernel of Matern's class with nu = 5/2; its length and size are the most probable of
a grid (Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, sections 4.2 and 5.4).
One whose most probable size is none has nothing to say (automatic relevance determination). An
error that comes and goes in time (a table that sways, a lamp that flickers) would take so short a
length that it followed noise: a line in the spectrum of the residual has three numbers only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.model import DeltaModel, own_place, sensible
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import PROCESSES
from deltactl.diagnosis.plants.delta.point import end_to_end
from deltactl.diagnosis.plants.regressor import Columns

UNKNOWN = "unknown@"


@dataclass(frozen=True, slots=True, eq=False)
class Process:
    """A process at an input location over a covariate.

    two_way: changes sign with the way the covariate came. shapes: (knots, k) of the kernel, each in
    its prior standard deviation. gain: log evidence that it adds. paid: for the choice of length
    and size. rate_hz: of a wave in time, which has no knots.
    """

    location: str
    covariate: str
    two_way: bool
    knots: FloatArray
    shapes: FloatArray
    gain: float = 0.0
    paid: float = 0.0
    rate_hz: float = 0.0

    @property
    def key(self) -> str:
        """Name among regressors."""
        ways = " two-way" if self.two_way else ""
        wave = " wave" if self.rate_hz else ""
        return f"{UNKNOWN}{self.location} {self.covariate}{ways}{wave}"

    def over(self, covariate: FloatArray) -> FloatArray:
        """Its shapes (m, k) at values (m,) of the covariate."""
        if self.rate_hz:
            return np.asarray(_wave(covariate, self.rate_hz) @ self.shapes)
        return np.asarray(_hats(covariate, self.knots, self.two_way) @ self.shapes)

    def columns(self, model: DeltaModel) -> Columns:
        """Its shapes in all channels (n c, k)."""
        over = self.over(model.covariates()[self.covariate])
        change = model.inputs()[self.location]
        values = end_to_end(change[:, :, None] * over[:, None, :])
        lasts = not self.rate_hz  # the phase is another one each time
        return Columns(values, np.ones(values.shape[1]), lasts=lasts)


Ways = tuple[Process, csr_array]
"""A process without its shapes, and the straight lines between knots (n, knots)."""


class Processes:
    """All processes that make sense on a machine."""

    def __init__(self, model: DeltaModel):
        self.model = model
        covariates = model.covariates()
        varying = {n: x for n, x in covariates.items() if np.ptp(x) > 1e-6 * np.abs(x).max()}
        knots = {n: _knots(x) for n, x in varying.items()}
        empty = np.zeros((PROCESSES.knots, 0))
        self.every: list[Ways] = []
        hats = {n: _hats(x, knots[n], False) for n, x in varying.items()}
        for location in model.inputs():
            for name in varying:
                if sensible(location, name):
                    one = Process(location, name, False, knots[name], empty)
                    self.every.append((one, hats[name]))
            own = own_place(location)
            if own in varying:
                one = Process(location, own, True, knots[own], empty)
                self.every.append((one, _hats(varying[own], knots[own], True)))

    def __len__(self) -> int:
        return len(self.every) + len(self.model.inputs())

    def remembering(self, one: Process) -> list[Ways]:
        """Processes at a place over earlier values of a covariate, and over the way it came."""
        t_s, now = self.model.readings.t_s, self.model.covariates()[one.covariate]
        pasts = [np.interp(t_s - late_s, t_s, now) for late_s in PROCESSES.past_s]
        found = [(one, _hats(past, one.knots, False)) for past in pasts]
        return [*found, (replace(one, two_way=True), _hats(now, one.knots, True))]

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
        seen = {n: (csr_array(o.T @ o), o.T @ free, o.T @ white) for n, o in operators.items()}
        for process, hats in among:
            power, with_free, with_left = seen[process.location]
            share = taken.root_of(np.asarray(hats.T @ with_free).T)
            gram = np.asarray((hats.T @ (power @ hats)).toarray()) - share.T @ share
            along = np.asarray(hats.T @ with_left) - share.T @ of_left
            best = _most_probable(process, gram, along)
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
        empty = np.zeros((2, 0))
        one = Process(location, "time", False, np.zeros(0), empty, paid=paid, rate_hz=rate_hz)
        return [(one, _wave(readings.t_s, rate_hz))]


def _wave(t_s: FloatArray, rate_hz: float) -> csr_array:
    """Sine and cosine (n, 2)."""
    turn = 2.0 * np.pi * rate_hz * t_s
    return csr_array(np.stack([np.sin(turn), np.cos(turn)], axis=1))


def _most_probable(process: Process, gram: FloatArray, along: FloatArray) -> Process | None:
    """The process with the length and size of most evidence; None where none has any."""
    gains: list[float] = []
    best: tuple[float, FloatArray] = (0.0, np.zeros((0, 0)))
    wave = [np.eye(2)] if process.rate_hz else []
    for shapes in wave or map(_kernel_shapes, PROCESSES.lengths):
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
