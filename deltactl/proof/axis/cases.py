"""Draw a case by its seed: a machine, what is hidden in it, and two runs of it; a case on disk.

Even seeds are for tuning the diagnosis, odd ones for judging it; seeds 2k and 2k + 1 have the same
tier and kind of machine, so that both halves of a range hold the same mixture.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.plain_file import write_whole
from deltactl.proof.axis.build import (
    HOLDOUT_SHARE,
    Design,
    Run,
    design,
    observer_of,
    prepare,
    scale_of,
    untidy,
)
from deltactl.proof.axis.catalogue import KINDS, LIMITS, UNKNOWN, Kind, Scale
from deltactl.proof.axis.commanded import CommandedAxis, Sizes, Values
from deltactl.proof.axis.forced import ForcedAxis
from deltactl.proof.axis.motions import ONE_WAY, FloatArray
from deltactl.proof.axis.observer import Alternatives, Observer, alternatives, bound, sized
from deltactl.recording.tables.flat import from_columns
from deltactl.recording.tables.flat_files import write_flat

_ROUND = (
    "none single unknown gross faint pair ambiguous single none unknown"
    " single pair tolerance gross three faint unknown single ambiguous none"
)
ROUND = tuple(_ROUND.split())
"""Tiers of twenty successive pairs of seeds."""
MACHINES = ("commanded", "effort", "range", "commanded", "effort", "effort", "commanded")
RATIOS = {
    "single": (1.0, 16.0),
    "gross": (20.0, 100.0),
    "faint": (0.08, 0.33),
    "pair": (1.0, 12.0),
    "three": (1.5, 12.0),
    "ambiguous": (1.0, 16.0),
    "unknown": (2.0, 20.0),
    "tolerance": (5.0, 16.0),
}
"""Root mean square of an effect over that of the noise."""
RATIOS_MOST = 1.6
"""How far an effect may exceed its tier's largest, where its size has no straight way there."""
SEEN = 225.0
"""Chi-square (15 standard deviations) that an effect has when all that is hidden beside it is
fitted; of the faint tier none is asked."""
RICHER = 25.0
"""Chi-square of what the words leave of the physics, from which on an unknown beside is true."""
SMALL = 0.7
"""Root mean square of an imperfection of the tolerance tier over the noise."""
NO_TOLERANCE = (*LIMITS, "lost_steps", "resonance")
"""No machine has a little of these by being built with ordinary care."""
_OF_A_SHAPE = ("resonance", "lost_steps", "joint_compliance", "transmission_error", "encoder_error")
NEVER_TIED = (*LIMITS, *_OF_A_SHAPE)
"""Effects with a pattern of their own in any motion that shows them."""
NOT_OF_TIER = {"tolerance": NO_TOLERANCE, "ambiguous": NEVER_TIED}
TRIES = 400
SAME_BY_WORD = {
    ("commanded", "following_lag"): ("viscous_friction",),
    ("effort", "following_lag"): ("sensor_latency",),
}
"""A lag of c / k of a shaft with viscous friction; a position that is read late."""


@dataclass(frozen=True)
class Hidden:
    """One thing that is hidden and what an ideal observer makes of it."""

    kind: Kind
    values: Values
    rms: float
    chi2: float
    alike: Alternatives
    culprit: bool = True
    """False for a small imperfection of the tolerance tier."""

    def truth(self, machine: str) -> dict[str, Any]:
        """As in the answers of the practice axes, with what an unknown follows."""
        effect = "unknown" if self.kind.unknown else self.kind.effect
        names = {effect, *self.alike.same, *SAME_BY_WORD.get((machine, effect), ())}
        names |= {"unknown"} if effect in LIMITS else set()
        found: dict[str, Any] = {
            "effect": effect,
            "where": "axis",
            "values": dict(self.values),
            "rms": self.rms,
            "chi2": self.chi2,
            "names": sorted(names),
            "ties": self.alike.ties,
        }
        if (machine, effect) == ("effort", "following_lag"):
            # Forces show by how much they come late, not how.
            found["values"] = {"total": sum(self.values.values())}
        if self.kind.unknown:
            found |= {"values": {}, "physics": self.kind.effect, "depends_on": self.kind.follows}
        return found


@dataclass
class AxisCase:
    """One machine with its two runs."""

    seed: int
    tier: str
    design: Design
    run: Run
    holdout: Run
    sizes: Sizes
    hidden: list[Hidden]
    also: list[str]
    observer: Observer = field(repr=False)

    def bound(self) -> dict[str, dict[str, float]]:
        """Cramer-Rao standard deviations, of the tiers whose every size has a name."""
        return bound(self.observer, self.sizes)

    def truth(self) -> dict[str, Any]:
        """In the form of the practice axes' answers."""
        plan, noise = self.design, self.observer.noise.scatter
        signal = self.observer.signal(self.sizes) - self.observer.signal({})
        linear, turning = ("N", "N m") if plan.machine == "effort" else ("m", "rad")
        high = max(noise, untidy(self.run, np.random.default_rng([self.seed, 47])))
        return {
            "case": f"axis_{self.seed:06d}",
            "seed": self.seed,
            "tier": self.tier,
            "machine": plan.machine,
            "unit": linear if plan.linear else turning,
            "answers": [cause.truth(plan.machine) for cause in self.hidden if cause.culprit],
            "also": self.also,
            "noise_rms": noise,
            "noise_rms_high": high,
            "mismatch_rms": self.observer.rms(signal),
            "rows": len(self.run.rows.true_s),
            "about": {
                "style": plan.style,
                "rate": plan.rate_hz,
                "seconds": plan.pace.seconds,
                "stroke": plan.pace.stroke,
                "stroke_s": plan.pace.stroke_s,
                "zero": "absolute" if plan.absolute else "arbitrary",
                "load": plan.loaded,
                "rho": plan.noise.rho,
                "outliers": plan.noise.outliers,
                "count": plan.noise.count / plan.noise.sigma,
                "jitter": plan.mess.jitter,
                "stamp": plan.mess.stamp,
                "drop": plan.mess.drop,
                "gaps": plan.mess.gaps,
                "held": plan.mess.held,
                "clock": plan.mess.clock_s,
            },
        }


def draw(seed: int) -> AxisCase:
    """The case of a seed; the same seed gives the same case."""
    turn = seed // 2
    tier = ROUND[turn % len(ROUND)]
    machine = MACHINES[turn % len(MACHINES)]
    rng = np.random.default_rng([seed, 41])
    for _ in range(TRIES):
        case = _try(seed, tier, machine, rng)
        if case is not None:
            return case
    raise ValueError(f"seed {seed}: no {tier} case of kind {machine} came out in {TRIES} tries")


def _try(seed: int, tier: str, machine: str, rng: np.random.Generator) -> AxisCase | None:
    """One attempt; None where what was drawn is not of its tier."""
    style = None
    if tier == "ambiguous" and rng.random() < 0.7:
        style = str(rng.choice(ONE_WAY))
    plan = design(machine, rng, fine=tier == "gross", style=style)
    run, holdout = prepare(plan, rng), prepare(plan, rng, HOLDOUT_SHARE)
    healthy = run.moved({})
    scale, observer = scale_of(healthy), observer_of(healthy)
    chosen = _choose(tier, plan, scale, rng)
    if chosen is None:
        return None
    sizes: dict[str, Values] = {}
    for number, kind in enumerate(chosen):
        ratio, least = SMALL * float(rng.uniform(0.5, 1.0)), 0.0
        if tier != "tolerance" or number == 0:
            least = kind.least(scale)
            ratio = float(np.exp(rng.uniform(*np.log(RATIOS[tier]))))
        drawn = {**kind.extras(rng, scale), "sign": float(rng.choice([-1.0, 1.0]))}
        sizes[kind.effect] = sized(observer, kind, drawn, scale, ratio, least)
    run = run.moved(sizes)
    observer = observer_of(run)
    hidden = [
        _seen(observer, plan, scale, sizes, kind, tier != "tolerance" or number == 0)
        for number, kind in enumerate(chosen)
    ]
    if not _of_tier(tier, hidden, observer):
        return None
    later = holdout.moved(_again(sizes))
    also = _also(observer, sizes, hidden, chosen)
    return AxisCase(seed, tier, plan, run, later, sizes, hidden, also, observer)


def _choose(tier: str, plan: Design, scale: Scale, rng: np.random.Generator) -> list[Kind] | None:
    """What to hide: of the vocabulary, or beyond it."""
    has = {"zero": plan.absolute, "load": scale.load > 0.0, "steps": plan.counted}
    if tier == "none":
        return []
    if tier == "unknown":
        kinds = _unknown_kinds(plan)
        return [kinds[int(rng.integers(len(kinds)))]]
    never = NOT_OF_TIER.get(tier, ())
    kinds = [
        kind
        for kind in KINDS[plan.machine]
        if (not kind.needs or has[kind.needs]) and kind.effect not in never
    ]
    count = {"pair": 2, "three": 3, "tolerance": 3}.get(tier, 1)
    picked = rng.permutation(len(kinds))[:count].tolist()
    return [kinds[number] for number in picked] if len(picked) == count else None


def _unknown_kinds(plan: Design) -> list[Kind]:
    """Kinds in no vocabulary; a weight only where the robot file could state one and does not."""
    weighs = not (plan.linear or plan.states_gravity)
    return [kind for kind in UNKNOWN[plan.machine] if weighs or kind.effect != "weight_not_given"]


def _seen(
    observer: Observer, plan: Design, scale: Scale, sizes: Sizes, kind: Kind, culprit: bool
) -> Hidden:
    """What an ideal observer makes of one effect among all that is hidden."""
    signal = observer.parts(sizes, kind.effect)
    without = {name: values for name, values in sizes.items() if name != kind.effect}
    # Beside the effect and without it: the phase of a wave moves with what shifts the axis.
    others = [
        column
        for beside in (sizes, without)
        for name in without
        for column in observer.free(beside, name)
    ]
    chi2 = observer.chi2(signal, others)
    alike = Alternatives([], [], chi2, chi2)
    if culprit:
        alike = alternatives(observer, KINDS[plan.machine], scale, sizes, kind.effect)
    return Hidden(kind, sizes[kind.effect], observer.rms(signal), chi2, alike, culprit)


def _of_tier(tier: str, hidden: Sequence[Hidden], observer: Observer) -> bool:
    """Whether what came out is what the tier promises."""
    noise = observer.noise.scatter
    culprits = [cause for cause in hidden if cause.culprit]
    if tier == "faint":
        return all(cause.rms < 0.5 * noise for cause in culprits)
    if any(
        min(cause.chi2, cause.alike.own) < SEEN or cause.rms > RATIOS_MOST * RATIOS[tier][1] * noise
        for cause in culprits
    ):
        return False
    if tier == "gross":
        return culprits[0].rms > 12.0 * noise and not culprits[0].alike.ties
    if tier == "ambiguous":
        # Beyond what is one operator in any motion: the motion itself makes this tie.
        return bool(_by_motion(culprits[0]))
    if tier == "unknown":
        return culprits[0].alike.nearest > SEEN
    return not any(cause.alike.ties or _by_motion(cause) for cause in culprits)


ALWAYS = (
    {"gear_backlash", "joint_friction"},
    {"transmission_error", "encoder_error"},
    {"following_lag", "sensor_latency"},
)


def _by_motion(cause: Hidden) -> set[str]:
    """Alternatives that another motion would separate from the effect."""
    always = {name for pair in ALWAYS if cause.kind.effect in pair for name in pair}
    return {*cause.alike.same, *cause.alike.ties} - always


def _again(sizes: Sizes) -> Sizes:
    """What another run of the same machine has: what happened once does not repeat."""
    return {name: values for name, values in sizes.items() if name != "lost_steps"}


def _also(
    observer: Observer, sizes: Sizes, hidden: Sequence[Hidden], chosen: Sequence[Kind]
) -> list[str]:
    """What may be named beside without being needless."""
    names = {name for kind in chosen for name in kind.beside}
    names |= {cause.kind.effect for cause in hidden if not cause.culprit}
    if not any(cause.kind.unknown for cause in hidden):
        words = observer.signal(sizes, ideal=True)
        richer = observer.chi2(observer.signal(sizes) - words) > RICHER
        # A faint effect that is seen may be reported without a name.
        faint = any(RICHER < cause.chi2 < SEEN for cause in hidden)
        names |= {"unknown"} if richer or faint else set()
    return sorted(names - {cause.kind.effect for cause in hidden if cause.culprit})


RECORDING, HOLDOUT, ROBOT_FILE = "recording.csv.gz", "holdout.csv.gz", "robot.yaml"
DIGITS = 9


def write_blind(case: AxisCase, folder: Path) -> None:
    """What the diagnosis may see: no word of what is hidden."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([case.seed, 43])
    for run, name in ((case.run, RECORDING), (case.holdout, HOLDOUT)):
        write_flat(from_columns(table(case, run, rng), name), folder / name)
    write_whole(folder / ROBOT_FILE, robot_file(case.design))


def write_answers(case: AxisCase, path: Path) -> None:
    """The truth, as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(case.truth(), indent=1) + "\n")


def table(case: AxisCase, run: Run, rng: np.random.Generator) -> dict[str, FloatArray]:
    """The columns of one recording."""
    plan, rows = case.design, run.rows
    once = case.sizes if run is case.run else _again(case.sizes)
    columns = {"t": rows.stamp_s}
    if isinstance(run.axis, ForcedAxis):
        at, speed, asked = run.axis.recorded(rows.true_s)
        read = plan.noise.read(at, rng)
        columns["position"] = read[rows.shown]
        columns["effort"] = plan.effort_noise.read(asked, rng) / plan.gain
        if plan.speed_column:
            rough = 3.0 * plan.noise.scatter / plan.pace.stroke_s
            columns["velocity"] = speed + rough * rng.standard_normal(len(speed))
        if plan.loaded:
            columns["load"] = np.interp(rows.true_s, run.motion.t_s, run.axis.load)
        return _rounded(columns)
    clean = run.axis.clean(once, rows.true_s)
    read = plan.noise.read(clean, rng)[rows.shown]
    if isinstance(run.axis, CommandedAxis):
        turns = "command_1" if plan.names == "theta_1" else "command"
        columns["steps_1" if plan.counted else turns] = run.axis.command(rows.true_s)
        columns["theta_1" if plan.counted else plan.names] = read
        if plan.loaded:
            columns["load"] = np.interp(rows.true_s, run.motion.t_s, run.axis.load)
    else:
        columns["distance"] = run.motion.at(rows.true_s)
        columns["range"] = read
    return _rounded(columns)


def _rounded(columns: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Written with as many digits as a log has."""
    return {
        name: np.array([float(f"{value:.{DIGITS}g}") for value in values])
        for name, values in columns.items()
    }


def robot_file(plan: Design) -> str:
    """What the machine was meant to be."""
    if plan.machine == "range":
        return "kind: range_sensor\nname: proof-sensor\n"
    zero = "absolute" if plan.absolute else "arbitrary"
    if plan.counted:
        # rad per microstep = 2 pi / (microsteps_per_rev * gear_ratio)
        gear = 2.0 * np.pi / (plan.step_size * 3200.0)
        drive = f"drive: {{microsteps_per_rev: 3200, gear_ratio: {gear:.10g}}}\n"
        return f"kind: stepper_axis\nname: proof-axis\nzero: {zero}\n{drive}"
    motion = "linear" if plan.linear else "rotary"
    text = f"kind: servo_axis\nname: proof-axis\nmotion: {motion}\n"
    if plan.machine == "commanded":
        return text + f"zero: {zero}\n"
    text += f"inertia: {plan.inertia:.10g}\neffort_gain: {plan.gain:.10g}\n"
    if not plan.states_gravity:
        return text
    if plan.linear:
        return text + f"gravity: {{force_n: {plan.weight:.10g}}}\n"
    torque, zero_rad = plan.gravity
    return text + f"gravity: {{torque_nm: {torque:.10g}, zero_rad: {zero_rad:.10g}}}\n"
