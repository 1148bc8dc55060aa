"""The run to do next: a safe job that separates explanations which one recording leaves tied."""

from diagnosis.experiment.job import write_job
from diagnosis.experiment.propose import Proposal, next_experiment, propose
from diagnosis.experiment.safe import MotionLimits
from diagnosis.experiment.ties import Tie

__all__ = ["MotionLimits", "Proposal", "Tie", "next_experiment", "propose", "write_job"]
