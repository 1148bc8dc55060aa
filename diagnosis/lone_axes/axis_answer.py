"""From an explanation of a lone axis to the contract's findings: sizes, evidence, alternatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from diagnosis.answer.records import (
    Channel,
    Evidence,
    Finding,
    ParameterResult,
    Picture,
    Unexplained,
    Where,
)
from diagnosis.estimation.covariance import NORMAL_95, parameters
from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter
from diagnosis.evidence.chi2_tail import log_sf
from diagnosis.lone_axes.axis_rivals import rivals
from diagnosis.lone_axes.axis_search import AxisSearch
from diagnosis.observations.readings import FloatArray
from diagnosis.plants.candidate import Candidate
from diagnosis.plants.forced_axis import EffortAxisModel
from models.effects.lone_axis import said

REGIMES = {
    "gear_backlash": "after reversals",
    "joint_friction": "in motion and after reversals",
    "viscous_friction": "in motion, in proportion to speed",
    "stribeck_friction": "in slow motion",
    "joint_compliance": "where the load is high",
    "home_offset": "everywhere, as a constant",
    "gear_ratio": "in proportion to the position",
    "transmission_error": "in step with the position",
    "encoder_error": "in step with the position",
    "lost_steps": "from one moment on",
    "following_lag": "in motion and just after it stops",
    "resonance": "after starts and stops",
    "inertia": "while the axis speeds up or slows down",
    "effort_gain": "wherever there is effort",
    "effort_offset": "everywhere, as a constant force",
    "sensor_scale": "in proportion to the distance",
    "sensor_crosstalk": "with the square of the distance",
    "sensor_latency": "in motion",
    "sensor_drift": "growing since the start of the recording",
}
FAINT_P = 0.01
OTHER_NOTHING = ("inertia", "joint_compliance", "following_lag", "lost_steps")
"""Effects whose first parameter is not the one that vanishes with them."""
SHIFTS = 1.3
"""Standard deviations that a change of smoothing stands for."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisOutcome:
    """A search under the final noise, and the solution it stands by."""

    search: AxisSearch
    solution: Solution
    first_cost: float
    """Cost of the robot file as it stands, under the same noise."""
    unit: str


def covariance(search: AxisSearch, solution: Solution) -> FloatArray:
    """Of all fitted numbers, by blocks of time (a sandwich), widened for how few those are.

    Never narrower than what independent noise of the size that is left would give.
    """
    fitter, rows = search.fitter, search.fitter.rows
    if not solution.tangent.shape[1]:
        return np.zeros((0, 0))
    tangent, residual = solution.tangent, solution.residual
    scale = np.maximum(np.linalg.norm(tangent, axis=0), 1e-30)
    scaled = tangent / scale
    bread = np.linalg.pinv(scaled.T @ scaled, rcond=1e-10, hermitian=True)
    blocks = search.blocks()
    product = scaled[:rows] * residual[:rows, None]
    sums = np.stack([np.bincount(blocks, weights=column) for column in product.T], axis=1)
    count = len(sums)
    meat = sums.T @ sums * (count / max(count - 1, 1)) + scaled[rows:].T @ scaled[rows:]
    sandwich = np.diag(bread @ meat @ bread)
    plain = np.diag(bread) * max(1.0, solution.cost / max(fitter.rows, 1))
    widest = np.sqrt(np.maximum(sandwich, plain) / np.maximum(np.diag(bread), 1e-300))
    widest *= float(stdtrit(max(count - 1, 2), 0.975)) / NORMAL_95
    cov: FloatArray = bread * np.outer(widest, widest) / np.outer(scale, scale)
    return cov + np.diag((SHIFTS * _shift(search, solution)) ** 2)


def _shift(search: AxisSearch, solution: Solution) -> FloatArray:
    """How far the numbers move when friction is taken at velocities that are smoothed longer."""
    moved = np.zeros(solution.tangent.shape[1])
    model = search.prepared.model
    if not isinstance(model, EffortAxisModel) or not solution.terms:
        return moved
    fitter = Fitter(model.blurrier(), search.fitter.whiten, search.fitter.nuisances)
    other = fitter.solve(solution.terms, solution.frees, solution.nuisances)
    for number, (term, again) in enumerate(zip(solution.terms, other.terms, strict=True)):
        moved[solution.columns_of(number)] = (again.at - term.at)[term.candidate.moved]
    return moved


def findings(outcome: AxisOutcome) -> list[Finding]:
    """All findings, the one that explains most first."""
    solution = outcome.solution
    if not solution.terms and not solution.frees:
        return []
    cov = covariance(outcome.search, solution)
    found = [_named(outcome, number, cov) for number in range(len(solution.terms))]
    found += [_free(outcome, number) for number in range(len(solution.frees))]
    return sorted(found, key=lambda f: -f.evidence.delta_chi2)


def doubtful(outcome: AxisOutcome) -> int | None:
    """Number of a term whose size cannot be told from none at all; None if there is none."""
    solution = outcome.solution
    if not solution.terms:
        return None
    cov = covariance(outcome.search, solution)
    for number, term in enumerate(solution.terms):
        part = solution.columns_of(number)
        main = term.candidate.kind.main.name
        size = parameters(term, cov[part, part]).get(main)
        nothing = term.candidate.kind.nothing
        if size is None or not np.isfinite(nothing) or term.candidate.effect in OTHER_NOTHING:
            continue
        if (
            min(low for _, low, _ in size.components)
            <= nothing
            <= max(high for _, _, high in size.components)
        ):
            return number
    return None


def _named(outcome: AxisOutcome, number: int, cov: FloatArray) -> Finding:
    solution, search = outcome.solution, outcome.search
    term = solution.terms[number]
    candidate = term.candidate
    rest = (*solution.terms[:number], *solution.terms[number + 1 :])
    bare = search.fitter.solve(rest, solution.frees, solution.nuisances)
    gain = max(bare.cost - solution.cost, 0.0) / search.excess(solution)
    part = solution.columns_of(number)
    sizes = parameters(term, cov[part, part])
    sizes.pop("start", None)
    sizes |= _assumed(candidate)
    readings = search.prepared.model.readings
    times, numbers = readings.whole, list(range(1, len(readings.shift_s) + 1))
    if candidate.effect == "lost_steps":
        sizes["time"] = _moment(outcome, bare, float(term.at[1]))
        numbers = [readings.recording_of(float(term.at[1]))]
        times = [(readings.own_time_s(float(term.at[1])), readings.end_s(numbers[0]))]
    plain = {name: np.asarray(v).tolist() for name, v in candidate.values(term.at).items()}
    df = max(len(candidate.moved), 1)
    return Finding(
        effect=candidate.effect,
        component=candidate.component,
        says=candidate.kind.sentence(candidate.component, plain),
        parameters=sizes,
        where=Where(
            axes=list(readings.names), times_s=times, recordings=numbers,
            regime=REGIMES.get(candidate.effect, "everywhere"),
        ),
        evidence=Evidence(delta_chi2=gain, p=search.p(log_sf(gain, df))),
        share_of_mismatch=_share(outcome, bare),
        alternatives=rivals(search, solution, number, bare),
    )  # fmt: skip


def _assumed(candidate: Candidate) -> dict[str, ParameterResult]:
    """What a size is given for, where it is not what everybody would assume (a stiffness)."""
    usual = {p.name: p for p in candidate.kind.parameters}
    return {
        name: ParameterResult(value=x, ci95=[x, x], unit=usual[name].unit)
        for name, value in candidate.fixed.items()
        if np.ndim(value) == 0 and np.isfinite(x := float(value)) and x != usual[name].default
        if name != "start"
    }


def _share(outcome: AxisOutcome, bare: Solution) -> float:
    """Part of the whole mismatch that comes back without the finding."""
    missing = max(outcome.first_cost - outcome.solution.cost, 1e-9)
    return float(np.clip((bare.cost - outcome.solution.cost) / missing, 0.0, 1.0))


def _moment(outcome: AxisOutcome, bare: Solution, time_s: float) -> ParameterResult:
    """When it happened, with the times that fit nearly as well."""
    from diagnosis.lone_axes.axis_jumps import gains

    search = outcome.search
    readings = search.prepared.model.readings
    times, gain = gains(search.fitter, bare, search.prepared.model)
    near = times[gain > gain.max() - 3.84 * search.excess(outcome.solution)]
    half = readings.period_s
    own = readings.own_time_s
    ends = [
        own(float(near.min(initial=time_s))) - half,
        own(float(near.max(initial=time_s))) + half,
    ]
    return ParameterResult(value=own(time_s), ci95=ends, unit="s")


def _free(outcome: AxisOutcome, number: int) -> Finding:
    solution, search = outcome.solution, outcome.search
    free = solution.frees[number]
    others = (*solution.frees[:number], *solution.frees[number + 1 :])
    bare = search.fitter.solve(solution.terms, others, solution.nuisances)
    gain = max(bare.cost - solution.cost, 0.0) / search.excess(solution)
    first = sum(f.size for f in solution.frees[:number])
    values = free.basis @ solution.coefficients[first : first + free.size]
    size = float(np.std(values))
    half = NORMAL_95 * size / max(float(np.sqrt(gain)), 1.0)
    readings = search.prepared.model.readings
    return Finding(
        effect="unknown",
        component=free.port,
        says=f"a mismatch of {said(size, outcome.unit)} (root mean square) follows {free.driver}, "
        "and nothing in the list of effects looks like it",
        parameters={
            "size_rms": ParameterResult(
                value=size, ci95=[max(size - half, 0.0), size + half], unit=outcome.unit
            )
        },
        where=Where(
            axes=list(readings.names),
            times_s=readings.whole,
            recordings=list(range(1, len(readings.shift_s) + 1)),
            regime=f"with {free.driver}",
        ),
        evidence=Evidence(delta_chi2=gain, p=search.p(log_sf(gain, free.size))),
        share_of_mismatch=_share(outcome, bare),
        depends_on=[free.driver],
    )


def unexplained(outcome: AxisOutcome, share: float) -> tuple[Unexplained, float]:
    """What is left, what it follows most, and the p of its being noise."""
    search, solution = outcome.search, outcome.solution
    scores, entries = search.scores(solution), search.prepared.library.entries
    free = [number for number, entry in enumerate(entries) if entry.free is not None]
    p = search.p(float(scores.log_p.min(initial=0.0)))
    if p > FAINT_P or not free:
        return Unexplained(share_of_mismatch=share, depends_on=[], says="What is left is noise."), p
    best = entries[min(free, key=lambda n: float(scores.log_p[n]))].free
    assert best is not None
    says = (
        f"{100 * share:.2g} % of the mismatch is left and is not noise (p = {p:.2g}); most of what "
        f"can be said of it is that it follows {best.driver}."
    )
    return Unexplained(share_of_mismatch=share, depends_on=[best.driver], says=says), p


def picture(outcome: AxisOutcome) -> Picture:
    """Arrays for drawings."""
    model = outcome.search.prepared.model
    readings = model.readings
    observed = np.where(readings.valid, readings.values, np.nan)
    channel = Channel(
        name=readings.names[0], unit=outcome.unit, observed=observed[:, 0],
        before=outcome.search.empty.predicted[:, 0], after=outcome.solution.predicted[:, 0],
        noise=outcome.search.fitter.whiten.channels[0].spread,
    )  # fmt: skip
    return Picture(
        t_s=readings.t_s, channels=[channel], drivers=model.drivers(), shift_s=readings.shift_s
    )
