"""What the engine needs to know of a machine: predictions, candidates, and spline terms.

The engine (fit, detect, name, settle) is written on this protocol alone. A new kind of machine
is one file with a class that has these members; see docs/life-of-a-recording.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from deltactl.diagnosis.observations.readings import FloatArray, Readings
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.nuisance import Nuisance


class Model(Protocol):
    """A machine with its recording."""

    readings: Readings
    candidates: list[Candidate]
    """Everything of the vocabulary that can act on this machine, also on all arms alike."""
    nuisances: list[Nuisance]
    """What is always fitted and never a finding."""
    tolerances: list[Nuisance]
    """What may be a little off everywhere on a machine as it is built, with usual spreads."""
    loosely_built: bool
    """Whether these were needed by an earlier diagnosis, and are among the nuisances."""

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """What the channels would have read without noise; shape (n, channels)."""
        ...

    def covariates(self) -> dict[str, FloatArray]:
        """Interpretable quantities over time that a model error may follow; name -> (n,)."""
        ...

    def inputs(self) -> dict[str, FloatArray]:
        """Components at which a spline term may enter -> change of the channels per unit there.

        Shape (n, channels) each.
        """
        ...
