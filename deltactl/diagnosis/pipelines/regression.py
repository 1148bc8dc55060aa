"""The way of a recording whose model error is a sum of columns: selected, settled, answered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import expit

from deltactl.diagnosis.admission.admit import Machine
from deltactl.diagnosis.answer.assembly import allowing, as_far_as_rows_tell, assembled
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import (
    Agreement,
    Diagnosis,
    Evidence,
    Finding,
    Fit,
    ParameterResult,
    Where,
)
from deltactl.diagnosis.answer.verdict import ALARM, NAMELESS, Rest, seen
from deltactl.diagnosis.assessment.detection_limits import detection_limits
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.assessment.persistence import with_persistence
from deltactl.diagnosis.assessment.regression_holdout import (
    Blocks,
    beyond_noise,
    on_blocks,
)
from deltactl.diagnosis.assessment.significance import (
    as_found,
    calibrated,
    chance,
    charge,
    prior_sensitivity,
)
from deltactl.diagnosis.experiment.propose import Proposal
from deltactl.diagnosis.observations.stale_readings import Stale
from deltactl.diagnosis.pipelines.agreement import agreement, widened
from deltactl.diagnosis.pipelines.regression_figures import (
    fit_of,
    left_by_known,
    picture_of,
    rest_of,
)
from deltactl.diagnosis.pipelines.regression_findings import covariance_as_left, findings, sizes
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.progress import Progress
from deltactl.diagnosis.selection.model_posterior import Posterior
from deltactl.diagnosis.selection.named_first import Selected, select
from deltactl.diagnosis.selection.near_points import select_near
from deltactl.models.effects import Search, Trait, found_by, has

NextRun = Callable[[Selected], Proposal]


def diagnose_plant(machine: Machine, progress: Progress, runs: NextRun) -> Diagnosis:
    """Noise, selection and alarm; then the answer, put together in one place.

    Without recordings that are held out, blocks of time are left out in turn. runs: designs the
    next run.
    """
    plant: RegressionPlant = machine.plant
    searched = (select if plant.own_noise is None else select_near)(plant, progress)
    plant = searched.plant
    charged = charge(plant, searched.noise, searched.empty)
    searched = _charged(searched, charged)
    first_p = _first_p(searched, charged)
    progress("what else it could be")
    selected, blocks = _widened(searched)
    if not _claimed(searched, first_p, blocks):
        nothing = Posterior([searched.empty], [1.0])
        selected, blocks = _widened(replace(searched, posterior=nothing, shift={}))
    compared = agreement(selected, machine.singles)
    settled = Settled(plant, searched, selected, blocks, first_p, machine.others, compared, runs)
    return settled.answer(progress)


@dataclass(frozen=True, eq=False)
class Settled:
    """The accepted explanation of a recording, and all that an answer says of it."""

    plant: RegressionPlant
    searched: Selected
    """Before its sizes were widened, or all of it was found to be chance."""
    selected: Selected
    blocks: Blocks
    first_p: float
    others: Sequence[RegressionPlant]
    compared: list[Agreement]
    """Sizes in each of several recordings."""
    runs: NextRun

    def answer(self, progress: Progress) -> Diagnosis:
        """Figures, limits, the next run and probabilities, of this explanation and of no other."""
        found, plant, best = self._findings, self.plant, self.selected.best
        fit, smallest = self._fit, detection_limits(self.selected)
        progress("what run would tell more")
        proposal = self.runs(self.selected)
        picture = picture_of(self.selected, plant)
        named = [one for one in found if one.effect != NAMELESS]  # an unknown has no prior size
        return assembled(
            found,
            with_persistence(fit, picture),
            self._chance,
            self._rest,
            probability_nothing_missing=self._nothing_missing(found),
            prior_sensitivity=as_found(prior_sensitivity(self.searched), named),
            next_experiment=proposal.experiment,
            open_ties=proposal.open,
            not_testable=plant.not_testable(),
            smallest_detectable=smallest,
            picture=picture,
            agreement=self.compared,
            **plant.remarks(best, covariance_as_left(self.selected)),
        )

    @cached_property
    def _findings(self) -> list[Finding]:
        found = findings(self.selected, self.plant.readings) + self._repeated
        found = [as_far_as_rows_tell(one, self.plant.readings.period_s) for one in found]
        return widened(found, self.compared)

    @property
    def _fit(self) -> Fit:
        fit = fit_of(self.selected, self.others, self._rest, self.blocks)
        if self.plant.left_by_known and not seen(self._rest.p):
            excused = bool(self.searched.best.found and not self.selected.best.found)
            fit = allowing(fit, left_by_known(self.selected, fit, excused))
        return fit

    @cached_property
    def _repeated(self) -> list[Finding]:
        """Old values that a sensor repeated."""
        return _repeated(self.plant, self.selected)

    @cached_property
    def _rest(self) -> Rest:
        return rest_of(self.selected)

    @property
    def _chance(self) -> float:
        """Calibrated p of 'nothing is missing', before any finding."""
        stale = min((one.evidence.p for one in self._repeated), default=1.0)
        by_fit = self.first_p if self.selected.best.found else min(self.first_p, self._rest.p)
        return min(by_fit, stale)

    def _nothing_missing(self, found: Sequence[Finding]) -> float:
        """Posterior probability that nothing is missing."""
        nothing = float(np.clip(self.selected.nothing, 0.0, 1.0))
        nothing *= 1.0 - max((one.probability or 0.0 for one in self._repeated), default=0.0)
        return nothing if found else calibrated(nothing, self._rest.p)


def _repeated(plant: RegressionPlant, selected: Selected) -> list[Finding]:
    """Findings of old values that a sensor repeated, one for each stretch."""
    return [_of_old_values(plant, selected, run) for run in plant.stale]


def _of_old_values(plant: RegressionPlant, selected: Selected, run: Stale) -> Finding:
    readings = plant.readings
    column, count = readings.names.index(run.channel), len(readings.t_s)
    begin, end = float(readings.t_s[run.first]), float(readings.t_s[run.last])
    rows = slice(column * count + run.first + 1, column * count + run.last + 1)
    miss, noise = selected.best.residual[rows], selected.noise
    own = noise.sigma[noise.rows // count == column]
    # Rounding makes it look one or two longer, nothing makes it look shorter.
    half, seconds = readings.period_s, end - begin + readings.period_s
    own_begin, own_end = (readings.own_time_s(t_s) for t_s in (begin, end))
    own_end += 0.5 * half
    own_begin -= 0.5 * half
    times = [[own_begin - half, own_begin + half], [own_end - half, own_end + half]]
    return Finding(
        effect=found_by(Search.REPEATS).name,
        component=run.channel,
        says="",
        parameters={
            "times_s": ParameterResult(value=[own_begin, own_end], ci95=times, unit="s"),
            "duration": ParameterResult(
                value=seconds, ci95=[seconds - 2.5 * half, seconds + half], unit="s"
            ),
        },
        where=Where(
            axes=[run.channel],
            times_s=[(own_begin, own_end)],
            recordings=[readings.recording_of(begin)],
        ),
        evidence=Evidence(
            delta_chi2=float(np.nansum(miss**2)) / float(np.median(own)) ** 2,
            p=float(np.exp(run.log_p)),
        ),
        probability=1.0 - float(np.exp(run.log_p)),
        share_of_mismatch=0.0 if selected.best.found else 1.0,
    )


def _together(selected: Selected, blocks: dict[str, float]) -> dict[str, float]:
    """Discrepancy of the sizes, of another preparation and of blocks left out."""
    names = selected.shift.keys() | blocks.keys()
    return {n: float(np.hypot(selected.shift.get(n, 0.0), blocks.get(n, 0.0))) for n in names}


def _widened(selected: Selected) -> tuple[Selected, Blocks]:
    """The same with the discrepancy of its sizes, and what it leaves of blocks left out.

    Less corrections of the file without which blocks left out are no worse.
    """
    blocks = on_blocks(selected)
    known = replace(selected, shift=_together(selected, beyond_noise(selected.best, blocks)))
    doubtful = _doubtful(known)
    if doubtful:
        best = selected.best
        fewer = [selected.evidence(best.keys - {key}, [best]) for key in doubtful]
        rest = Posterior([max(fewer, key=lambda one: one.log_evidence)], [1.0])
        trimmed, left = _widened(replace(selected, posterior=rest))
        if left.after <= VERDICT.grew * blocks.after:
            return trimmed, left
    return known, blocks


def _doubtful(selected: Selected) -> list[str]:
    """Corrections of the file whose interval holds what the file says: of a ratio and an offset
    that make up for each other one may be needed.
    """
    signed = {r.key for r in selected.plant.regressors if has(r.effect, Trait.SIGNED)}
    found = []
    for key in sorted(selected.best.found & signed):
        shown = selected.plant.shown(key)
        ((_, low, high),) = sizes(selected, key)[shown[0].name].components
        if low <= shown[0].nothing <= high:
            found.append(key)
    return found


def _claimed(selected: Selected, first_p: float, blocks: Blocks) -> bool:
    """Whether anything may be: by the test, or by test, evidence and held-out blocks together.

    Of a coarse encoder's few hundred readings eight may be independent; a test that estimates the
    noise from those few and counts all that was tried sees nothing in a lag of half the motion.
    Where sizes that were fitted elsewhere take most of the model error of every block away, no such
    test is needed.
    """
    likely = first_p <= ASSESSMENT.unlikely and blocks.after < blocks.before
    foretold = blocks.after < ASSESSMENT.foretold * blocks.before
    return first_p <= ALARM or (selected.nothing <= ALARM and (likely or foretold))


def _first_p(selected: Selected, charged: float) -> float:
    """Calibrated p of 'nothing is missing', before any finding."""
    best, empty = selected.best, selected.empty
    if best.found:
        return chance(selected, best, empty, charged)
    singles = [r for r in selected.plant.regressors if not r.left_over and not r.beside]
    possible = [selected.evidence([one.key]) for one in singles]
    tried = [e for e in possible if np.isfinite(e.log_evidence) and e.found]
    return min([chance(selected, one, empty, charged) for one in tried], default=1.0)


def _charged(selected: Selected, charged: float) -> Selected:
    """The same, with what the file's effects may leave taken off the evidence of anything more."""
    best, empty = selected.best, selected.empty
    if not best.found or charged <= 0.0:
        return selected
    against = best.log_evidence - empty.log_evidence - 0.5 * charged
    return replace(selected, nothing=max(selected.nothing, float(expit(-against))))
