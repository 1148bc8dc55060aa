"""What the answer says of a delta near a point: parameters, channels, limits, tolerances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.special import chdtrc

from deltactl.diagnosis.answer.finding import Finding, ParameterResult
from deltactl.diagnosis.answer.picture import Channel, Picture
from deltactl.diagnosis.answer.records import AllowedFor, NotTestable
from deltactl.diagnosis.answer.verdict import Rest
from deltactl.diagnosis.assessment.intervals import parameters, spreads
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.observations.largest_noise import (
    Bound,
    NoiseBounds,
    remembering,
    segment_for,
    spectrum,
)
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.delta.jumps import TIME, Jump, jumps, late_of
from deltactl.diagnosis.plants.delta.messy_effects import MessyEffects
from deltactl.diagnosis.plants.delta.noise_of_channels import in_figures
from deltactl.diagnosis.plants.delta.point import (
    Near,
    coordinate_name,
    key_of,
    side_by_side,
)
from deltactl.diagnosis.plants.delta.what_it_follows import Followed
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.diagnosis.plants.regressor import Draws, Shown
from deltactl.diagnosis.priors.options import PENALTIES


class AnswerNearPoint(MessyEffects):
    """The part of a delta's plant that the answer is made of."""

    count: int

    @cached_property
    def acting(self) -> dict[str, Near]:
        """What is at work, in its derivatives."""
        raise NotImplementedError

    @property
    def held(self) -> IntArray:  # type: ignore[override]
        """See `RegressionPlant`."""
        return self.recorded.held

    @property
    def left_by_known(self) -> Sequence[tuple[float, FloatArray]]:  # type: ignore[override]
        """See `RegressionPlant`."""
        return [(one.kind.discrepancy.elsewhere, own) for one, own in self._of_file]

    @property
    def done_by_known(self) -> FloatArray | None:  # type: ignore[override]
        """What all of them do (n c,)."""
        each = [own for _, own in self._of_file]
        return np.sum(each, axis=0) if each else None

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What a model error may follow, the same for all channels."""
        every = self.recorded.model.covariates()
        return {name: np.tile(values, self.count) for name, values in every.items()}

    def shown_on(self, change: FloatArray) -> list[str]:
        """Channels that show a change (n c,), in standard deviations of their noise."""
        spread = np.array([one.spread for one in self.own_noise.whitener.channels])
        power = np.mean((side_by_side(change, self.count) / spread) ** 2, axis=0)
        order = np.argsort(-power)
        return [
            self.readings.names[i]
            for i in order
            if power[i] >= ASSESSMENT.share_of_axis * power.sum()
        ]

    def parameters(
        self, key: str, sizes: FloatArray, covariance: FloatArray
    ) -> dict[str, ParameterResult] | None:
        """Parameters of an effect at work by its coordinates."""
        if key not in self.at_work:
            return None
        near = self.acting[key]
        return parameters(near.moved_by(sizes, True), covariance + near.discrepancy(sizes))

    def spread(self, key: str, sizes: FloatArray, covariance: FloatArray) -> dict[str, list[float]]:
        """How far the parameters of an effect at work are off together."""
        if key not in self.at_work:
            return {}
        near = self.acting[key]
        return spreads(near.moved_by(sizes, True), covariance + near.discrepancy(sizes))

    def shown(self, key: str) -> Sequence[Shown]:
        """The main parameter, for limits of detection."""
        if key not in self.candidates:
            return ()
        candidate = self.candidates[key]
        main, first = candidate.kind.main, candidate.coordinates[candidate.moved[0]]
        name = coordinate_name(candidate, candidate.moved[0])
        if first.parameter != main.name or first.how == "log":
            return ()
        at = 0.0 if first.how == "reciprocal" else candidate.kind.nothing

        def of(values: Draws) -> FloatArray:
            size = values[name] + at
            return np.asarray(1.0 / size if first.how == "reciprocal" else size)

        return [Shown(main.name, main.unit, of, at)]

    def remarks(self, best: Explanation, covariance: FloatArray) -> dict[str, Any]:
        """Whether it was built with less care than usual, and what is off then."""
        small = sorted((best.keys - best.found) & self.at_work.keys())
        loose = self.careful > PENALTIES.most_careful or bool(small)
        names = np.array(self.free().names)
        places = {name: np.flatnonzero(names == name) for name in self.free().names}
        sizes = {name: best.linear[""][at] for name, at in places.items()}
        known = {name: covariance[np.ix_(at, at)] for name, at in places.items()}
        for key in small:
            at = np.array([i for i, name in enumerate(best.names) if name.startswith(f"{key}.")])
            sizes[key], known[key] = best.linear[key], covariance[np.ix_(at, at)]
        tolerances = self.recorded.model.tolerances
        allowed = allowed_for(tolerances, sizes, known) if loose else []
        return {
            "loosely_built": loose or self.recorded.model.loosely_built,
            "allowed_for": allowed,
        }

    def described(
        self, finding: Finding, keys: Sequence[str], best: Explanation, without: Explanation
    ) -> dict[str, Any]:
        """What an unknown follows, and when a jump happened."""
        processes = [self.unknown[key] for key in keys if key in self.unknown]
        if processes:
            return Followed(self.recorded, self.own_noise, processes, best, without).fields()
        term = self.at_work.get(keys[0])
        if term is None or not term.candidate.kind.event:
            return {}
        late_s = late_of(self.at_work.values())
        left, free = without.residual, without.tangent
        found = jumps(self.recorded.model, self.own_noise, left, free, late_s)
        jump = found.get(term.candidate.component)
        return {} if jump is None else self._when(jump, finding)

    def _when(self, jump: Jump, finding: Finding) -> dict[str, Any]:
        """The time of a jump as its recording counts it, and all after it."""
        number = self.readings.recording_of(jump.time_s)
        begin_s, end_s = self.readings.whole[number - 1]
        shift_s = self.readings.shift_s[number - 1]
        low, high = (float(np.clip(x - shift_s, begin_s, end_s)) for x in jump.interval_s)
        time = ParameterResult(value=jump.time_s - shift_s, ci95=[low, high], unit="s")
        where = {"times_s": [(jump.time_s - shift_s, end_s)], "recordings": [number]}
        return {
            "parameters": {**finding.parameters, TIME: time},
            "where": finding.where.model_copy(update=where),
        }

    def rest(self, best: Explanation, charged: float) -> Rest:
        """What is left, by processes: a Bayes factor is as large by chance as seldom as Ville's
        inequality says, less what effects at work or of the file may leave.
        """
        known = self.recorded.processes
        found = known.probable(self.own_noise, best.residual, best.tangent)
        if not found:
            return Rest(1.0)
        gain = found[0].gain - found[0].paid - 0.5 * (self.left_by_names() + charged)
        p = math.exp(min(math.log(len(known)) - gain, 0.0))
        share = float(np.clip(2.0 * found[0].gain / best.chi2, 0.0, 1.0))
        return Rest(p, found[0].follows, found[0].component, share)

    def noise_bounds(self, left: FloatArray) -> NoiseBounds | None:
        """What bounds the noise of the channels that figures are of; see `RegressionPlant`."""
        channels = side_by_side(left, self.count)
        groups = np.cumsum(self.readings.fresh).astype(np.intp)
        bounds = []
        for column in np.flatnonzero(in_figures(self.readings)):
            read = np.flatnonzero(self.recorded.valid[:, column])
            seen = spectrum(channels[read, column], groups[read], segment_for(len(read)))
            if seen is None:
                return None
            bounds.append(Bound(seen, remembering(seen.angle)))
        every = block_diag(*(one.shapes for one in bounds))
        parts = np.split(every, np.cumsum([len(one.shapes) for one in bounds])[:-1])
        own = [Bound(one.seen, part) for one, part in zip(bounds, parts, strict=True)]
        return NoiseBounds(own, np.full(every.shape[1], 1.0 / len(bounds)))

    def drawn(self, picture: Picture) -> Picture:
        """A channel for each sensor, with what a sensor repeated where it did."""
        (whole,) = picture.channels
        readings, noises = self.readings, self.own_noise.whitener.channels
        before, after = (side_by_side(x, self.count) for x in (whole.before, whole.after))
        for run in self.stale:
            column = readings.names.index(run.channel)
            after[run.first : run.last + 1, column] = readings.values[run.first, column]
        observed = np.where(readings.valid, readings.values, np.nan)
        channels = [
            Channel(
                name=name,
                unit=readings.units[i],
                observed=observed[:, i],
                before=before[:, i],
                after=after[:, i],
                noise=noises[i].spread,
                counted=self.recorded.valid[:, i].astype(np.float64),
            )
            for i, name in enumerate(readings.names)
        ]
        follows = self.recorded.model.covariates()
        update = {"t_s": readings.t_s, "channels": channels, "covariates": follows}
        return picture.model_copy(update=update)

    def not_testable(self) -> list[NotTestable]:
        """Effects that change nothing in this recording."""
        why = "nothing that was observed depends on it in this recording"
        seen = {key for key in self.candidates if np.any(self.near[key].slopes)}
        return [
            NotTestable.of(one.effect, one.component, why)
            for one in self.recorded.model.candidates
            if key_of(one) not in seen and not one.members
        ]


def allowed_for(
    tolerances: Sequence[Nuisance], sizes: dict[str, FloatArray], known: dict[str, FloatArray]
) -> list[AllowedFor]:
    """Tolerances that are clearly not nothing, the one farthest off first.

    sizes: fitted (k,), with their covariances (k, k), by the names of the free columns.
    """
    found = []
    for nuisance in tolerances:
        candidate, key = nuisance.term.candidate, key_of(nuisance.term.candidate)
        off, covariance = sizes.get(key, np.zeros(0)), known.get(key, np.zeros((0, 0)))
        if len(off) != len(candidate.moved) or not _clear(off, covariance):
            continue
        at = nuisance.term.at.copy()
        at[candidate.moved] += off
        usual = PENALTIES.within * max(nuisance.spread)
        found.append(
            AllowedFor(
                effect=candidate.effect,
                component=candidate.component,
                parameters=parameters(nuisance.term.moved_to(at), covariance),
                usual=usual,
                times_usual=float(np.linalg.norm(off)) / usual,
            )
        )
    return sorted(found, key=lambda one: -one.times_usual)


def _clear(off: FloatArray, covariance: FloatArray) -> bool:
    """Whether fitted numbers (k,) are as far off nothing as chance hardly brings them."""
    gain = float(off @ np.linalg.pinv(covariance, hermitian=True) @ off)
    return bool(chdtrc(len(off), gain) < chdtrc(1, ASSESSMENT.clearly_off**2))
