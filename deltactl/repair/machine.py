"""A robot of an independent simulator with hidden faults, which draws plans and takes surveys.

The robot is MuJoCo's of `proof`: its bodies, contacts and friction share nothing with the chain
that explains it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.hidden.oddities import ODDITIES
from deltactl.proof.hidden.vocabulary import VOCABULARY, construct, hidden, plan, settle
from deltactl.proof.motions import survey
from deltactl.proof.recorded import Machine, record
from deltactl.proof.robot.as_built import StepTrain
from deltactl.proof.robot.run import run
from deltactl.recording.tables.flat import FlatRecording
from deltactl.repair.played import Drawn, Played, drawn

SURVEY_T_PWM_S = 0.002


@dataclass(eq=False)
class FaultyRobot:
    """A machine, and what is wrong with it."""

    machine: Machine
    answers: list[Hidden]
    seed: int

    def draw(self, job: Played) -> Drawn:
        """Run a job and see where the platform truly was."""
        truth = run(self.machine.robot, cast(StepTrain, job), np.zeros(3))
        return drawn(job, truth.t_s, truth.position_m)

    def survey(self, seconds: float) -> FlatRecording:
        """What the sensors see while the arms go to random angles."""
        rng = np.random.default_rng([self.seed, 3])
        return record(self.machine, survey(rng, seconds, SURVEY_T_PWM_S), rng)


def faulty_robot(effects: list[str], seed: int, unknown: bool = False) -> FaultyRobot:
    """A robot with these effects of the vocabulary built in, at sizes drawn by the seed.

    unknown: and something that is in no vocabulary. Raises ConfigError for an unknown name.
    """
    for name in effects:
        if name not in VOCABULARY:
            there = ", ".join(sorted(VOCABULARY))
            raise ConfigError(f"effect '{name}' cannot be hidden; there are {there}")
    rng = np.random.default_rng([seed, 1])
    machine = Machine()
    planned = [plan(VOCABULARY[name], rng, 1.0) for name in effects]
    settle(planned, rng, survey(np.random.default_rng([seed, 2]), 60.0, SURVEY_T_PWM_S))
    answers = []
    if unknown:
        build = ODDITIES[str(rng.choice(sorted(ODDITIES)))]
        answers.append(build(machine, rng, 1.0))
    construct(machine, planned, with_events=True)
    return FaultyRobot(machine, [*[hidden(part) for part in planned], *answers], seed)
