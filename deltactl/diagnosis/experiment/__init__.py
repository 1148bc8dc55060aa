"""The run to do next: a safe job that separates explanations which one recording leaves tied.

In: tied explanations and the noise of the recording. Out: the safe run that tells most of them
apart, as a job, and what it leaves open.
"""

from deltactl.diagnosis.experiment.propose import Proposal, next_experiment, write_job
from deltactl.diagnosis.experiment.ties import Tie

__all__ = ["Proposal", "Tie", "next_experiment", "write_job"]
