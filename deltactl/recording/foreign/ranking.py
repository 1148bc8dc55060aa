"""Which of several columns that could be the same thing it is: by name, and by what values do.

A reading follows its command; an effort goes with the acceleration and with the direction of the
motion. A name that says more precisely what it is comes before one that says less.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from deltactl.recording.foreign.names import MEASURED, TORQUES, Guess, Named, in_words
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import correlation
from deltactl.recording.reading.columns import FloatArray

CURRENTS = frozenset(["current", "strom", "iq", "i_q", "courant", "corriente", "corrente", "amps"])


def ranked(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> dict[str, Guess]:
    """The same guesses, of several commands or efforts of one axis the likeliest first.

    `why` says what its values do.
    """
    position = next((n for n, guess in found.items() if guess.role == "position"), None)
    if position is None:
        return dict(found)
    own = _of_one_joint(position, list(found))
    first: dict[str, Guess] = {}
    for role, rank in (("command", _command_rank), ("effort", _effort_rank)):
        several = [n for n, guess in found.items() if guess.role == role and guess.index is None]
        if len(several) < 2:
            continue
        ranks = {n: (n not in own, *rank(table, said, n, position)) for n in several}
        best = min(several, key=lambda name: ranks[name])
        share = -float(ranks[best][-1])
        does = "position follows it" if role == "command" else "it goes with the motion"
        why = (
            f"by its name; {does} ({share:.0%})" if share >= GUESSES.least_share else "by its name"
        )
        first[best] = replace(found[best], why=why)
    return first | {name: guess for name, guess in found.items() if name not in first}


def _of_one_joint(position: str, names: list[str]) -> set[str]:
    """Columns that begin as the position's name does, where several do: X_Position, X_Current."""
    begins = re.split(r"[^0-9A-Za-z]+", position)[0]
    return {name for name in names if re.split(r"[^0-9A-Za-z]+", name)[0] == begins} or set(names)


def _command_rank(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], name: str, position: str
) -> tuple[float, ...]:
    """Smaller is likelier; the last is minus the share of the position that follows it."""
    likeness = max(correlation(table[name], table[position]), 0.0)
    return (float(likeness**2 < GUESSES.least_share), -(likeness**2))


def _effort_rank(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], name: str, position: str
) -> tuple[float, ...]:
    """Smaller is likelier; the last is minus the share that goes with the motion."""
    words = set(in_words(name))
    kind = 0 if words & TORQUES else 1 if words & CURRENTS else 2
    share = _share_of_motion(table[name], table[position])
    asked = float(said[name].asked)
    unlikely = float(share < GUESSES.least_share)
    indirect = float(kind == 2)
    return (indirect, unlikely, asked, kind, float(not words & MEASURED), -share)


def _share_of_motion(effort: FloatArray, position: FloatArray) -> float:
    """Share of an effort's variance that acceleration, speed and its sign explain.

    Over several spans of rows, of which the best counts: noise of a position rules over few.
    """
    shares = [0.0]
    for rows in GUESSES.slope_rows:
        if len(position) < GUESSES.fewest_in_common * rows:
            break
        at = np.nan_to_num(position[::rows], nan=float(np.nanmean(position)))
        seen = effort[::rows]
        speed = np.gradient(at)
        shapes = np.stack([np.gradient(speed), speed, np.sign(speed), np.ones(len(at))], axis=1)
        known = np.isfinite(seen)
        left = len(seen[known]) - shapes.shape[1]
        spread = float(np.var(seen[known])) if left > 0 else 0.0
        if spread > 0.0:
            size = np.linalg.lstsq(shapes[known], seen[known], rcond=None)[0]
            missed = float(np.sum((seen[known] - shapes[known] @ size) ** 2)) / left
            shares.append(1.0 - missed / spread)
    return max(shares)
