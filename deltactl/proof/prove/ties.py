"""Pairs of causes that one recording cannot tell apart: drawn, diagnosed, settled or not.

A tie is diagnosed, what the answer proposes is run on the same robot, and both recordings are
diagnosed together. The score says whether the tie was admitted, and settled by that run.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import DeltactlError
from deltactl.proof.cases import Case, move, write_blind
from deltactl.proof.hidden.hidden import ARMS, MOTORS, Parameters, either_sign
from deltactl.proof.hidden.vocabulary import VOCABULARY, Planned, construct, hidden
from deltactl.proof.motions import from_job
from deltactl.proof.prove.one_case import diagnose_blind
from deltactl.proof.prove.table import Row, share
from deltactl.proof.ranging import Noise
from deltactl.proof.recorded import Machine, record
from deltactl.recording.tables.flat_files import write_flat

Name = tuple[str, str]
Parts = list[Planned]


@dataclass(frozen=True)
class Tie:
    """Two explanations; one of them is built in. `motion` is one on which they tie."""

    name: str
    motion: str
    build: Callable[[np.random.Generator, int, bool], tuple[Parts, list[Name]]]
    """(rng, arm, first or second) -> what is built in, and the names of the alternative."""
    settleable: bool = True
    """Whether a motion can tell them apart at all."""


def _part(effect: str, index: int, **parameters: float) -> Planned:
    values: Parameters = dict(parameters)
    return Planned(VOCABULARY[effect], index, values)


def _play(rng: np.random.Generator, arm: int, first: bool) -> tuple[Parts, list[Name]]:
    width = float(rng.uniform(0.006, 0.010))
    names: list[Name] = [("gear_backlash", MOTORS[arm]), ("joint_friction", MOTORS[arm])]
    if first:
        drag = float(rng.uniform(6.0, 15.0))
        return [_part("gear_backlash", arm, width=width, friction=0.05, drag=drag)], names[1:]
    return [_part("joint_friction", arm, width=width)], names[:1]


def _late(rng: np.random.Generator, _: int, first: bool) -> tuple[Parts, list[Name]]:
    late_s = float(rng.uniform(0.08, 0.16))
    if first:
        lags = [_part("following_lag", m, time=0.0, dead_time=late_s) for m in range(3)]
        return lags, [("sensor_latency", "sensors")]
    return [_part("sensor_latency", 0, time=late_s)], [("following_lag", m) for m in MOTORS]


def _one_way(rng: np.random.Generator, arm: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        lag = _part("following_lag", arm, time=float(rng.uniform(0.08, 0.16)), dead_time=0.0)
        return [lag], [("motor_azimuth", MOTORS[arm])]
    azimuth = _part("motor_azimuth", arm, angle=either_sign(rng, 0.012, 0.024))
    return [azimuth], [("following_lag", MOTORS[arm])]


def _one_arm(rng: np.random.Generator, arm: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        home = _part("home_offset", arm, angle=either_sign(rng, 0.010, 0.018))
        return [home], [("forearm_length", ARMS[arm])]
    length = _part("forearm_length", arm, length_error=either_sign(rng, 0.003, 0.005))
    return [length], [("home_offset", MOTORS[arm])]


def _height(rng: np.random.Generator, _: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        angle = either_sign(rng, 0.010, 0.018)
        homes = [_part("home_offset", m, angle=angle) for m in range(3)]
        return homes, [("sensor_offset", "range_z")]
    offset = _part("sensor_offset", 2, offset=either_sign(rng, 0.003, 0.006))
    return [offset], [("home_offset", m) for m in MOTORS]


def _sag(rng: np.random.Generator, _: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        error = either_sign(rng, 0.001, 0.002)
        lengths = [_part("upper_arm_length", a, length_error=error) for a in range(3)]
        return lengths, [("joint_compliance", "joints")]
    soft = _part("joint_compliance", 0, stiffness=float(rng.uniform(250.0, 450.0)))
    return [soft], [("upper_arm_length", a) for a in ARMS]


TIES = (
    Tie("backlash or friction wind-up", "survey", _play),
    Tie("drive lag or sensor latency", "survey", _late, settleable=False),
    Tie("arm lag or motor azimuth", "circle", _one_way),
    Tie("home offset or forearm length", "circle", _one_arm),
    Tie("all homes or z sensor offset", "circle", _height),
    Tie("upper arms or compliance", "circle", _sag),
)


SECOND = "second.csv.gz"
LONGEST_S = 900.0
T_PWM_S, SECONDS = 0.002, 90.0


def draw_tie(seed: int, number: int) -> tuple[Case, Tie, list[tuple[str, str]]]:
    """The case, its pair, and the names of the alternative. Pairs and truths take turns."""
    tie = TIES[number % len(TIES)]
    rng = np.random.default_rng([seed, number, 2])
    parts, alternative = tie.build(rng, int(rng.integers(3)), number // len(TIES) % 2 == 0)
    noise = Noise(float(rng.uniform(0.0015, 0.003)), float(rng.choice([0.0, 0.3, 0.6])))
    machine = Machine(noise=noise)
    construct(machine, parts, with_events=False)
    trains = [move(rng, tie.motion, SECONDS, T_PWM_S) for _ in range(2)]
    answers = [hidden(part) for part in parts]
    case = Case(number, "tie", tie.motion, machine, machine, trains[0], trains[1], answers, parts)
    return case, tie, alternative


def run_tie(seed: int, number: int) -> dict[str, Any]:
    """The truth, the alternative, the first answer and, when a job was proposed, the second."""
    case, tie, alternative = draw_tie(seed, number)
    second: dict[str, Any] | None = None
    with tempfile.TemporaryDirectory(prefix="prove-") as name:
        folder = Path(name)
        write_blind(case, folder, seed)
        first, failure = diagnose_blind(folder)
        proposal = (first or {}).get("next_experiment")
        if proposal is not None:
            second, failure = _second(case, proposal["job"], folder, seed)
    truth = {"seed": seed, "truth": case.truth(), "pair": tie.name, "settleable": tie.settleable}
    answers = {"first": first, "second": second, "failure": failure}
    job = proposal and proposal["job"]
    return truth | answers | {"alternative": [list(n) for n in alternative], "proposed": job}


def _second(
    case: Case, job: dict[str, Any], folder: Path, seed: int
) -> tuple[dict[str, Any] | None, str | None]:
    try:
        train = from_job(job)
        if train.seconds > LONGEST_S:
            return None, f"the proposed job takes {train.seconds / 60.0:.0f} minutes"
        rng = np.random.default_rng([seed, case.number, 3])
        write_flat(record(case.machine, train, rng), folder / SECOND)
    except (DeltactlError, KeyError, TypeError, ValueError) as error:
        return None, f"the proposed job cannot be run: {type(error).__name__}: {error}"
    return diagnose_blind(folder, also=(SECOND,))


@dataclass(frozen=True)
class TieScore:
    """`admitted`: the first answer offers both. `settled`: the last one holds to the truth."""

    pair: str
    settleable: bool
    proposed: bool
    admitted: bool
    settled: bool
    told: bool
    """Some answer says which measurement would settle what no motion can."""


def score_tie(result: dict[str, Any]) -> TieScore:
    """Score what `run_tie` returned.

    Where no motion can settle a pair, to admit the tie is all that can be right.
    """
    truth = {(line["effect"], line["where"]) for line in result["truth"]["answers"]}
    alternative = {(effect, where) for effect, where in result["alternative"]}
    named, offered = _names(result["first"])
    admitted = bool(truth & offered) and bool(alternative & offered)
    proposed = result["proposed"] is not None
    told = any(_open(result[n]) for n in ("first", "second"))
    if not result["settleable"]:
        return TieScore(result["pair"], False, proposed, admitted, admitted, told)
    if proposed:
        named, offered = _names(result["second"])
    settled = truth <= named and not alternative & offered
    return TieScore(result["pair"], True, proposed, admitted, settled, told)


def _open(answer: dict[str, Any] | None) -> bool:
    """Whether an answer names a pair that needs a measurement by hand."""
    return answer is not None and bool(answer.get("open_ties"))


def _names(answer: dict[str, Any] | None) -> tuple[set[Name], set[Name]]:
    """Names of the findings; and with their alternatives."""
    found = [] if answer is None else answer["findings"]
    named = {(f["effect"], f["component"]) for f in found}
    others = {(a["effect"], a["component"]) for f in found for a in f["alternatives"]}
    return named, named | others


SETTLED = attrgetter("settled")


def tie_rows(scores: Sequence[TieScore]) -> list[Row]:
    """Rows for the table."""
    pairs = sorted({s.pair for s in scores})
    can = [s for s in scores if s.settleable]
    cannot = [s for s in scores if not s.settleable]
    ran = [s for s in can if s.proposed]
    alone = [s for s in can if not s.proposed]
    return [
        share("ties: settled after the proposed run", can, SETTLED, 0.90),
        share("... where a run was proposed", ran, SETTLED),
        share("... where the first answer alone was to decide", alone, SETTLED),
        share("... the first answer offered both", scores, lambda s: s.admitted),
        share("... a run was proposed", can, lambda s: s.proposed),
        share("... no motion can settle: says which measurement", cannot, lambda s: s.told),
        *(share(f"... {p}", [s for s in scores if s.pair == p], SETTLED) for p in pairs),
    ]
