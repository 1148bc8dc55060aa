"""Ticks as the board holds them: a due time and one byte (see Board) for each."""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Int8Array, Int64Array, Ticks

Codes = np.ndarray[Any, np.dtype[np.uint8]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]

_MOTORS = np.arange(MOTORS, dtype=np.uint8)
_STEPPING = np.array([1, 2, 4], dtype=np.uint8)
_NEGATIVE = _STEPPING << 3
_EVERY = np.arange(64)[:, np.newaxis]
_STEPS_OF = ((_EVERY >> _MOTORS & 1) * (1 - 2 * (_EVERY >> _MOTORS + 3 & 1))).astype(np.int8)
"""Steps of each of the 64 codes."""


def as_ticks(ticks: Ticks) -> tuple[Int64Array, Codes]:
    """Due times and codes, each of shape (n,). Raises ValueError when they are no ticks."""
    due_ns = np.asarray(ticks.due_ns)
    steps = np.asarray(ticks.steps)
    if due_ns.ndim != 1 or steps.shape != (len(due_ns), MOTORS):
        raise ValueError(f"ticks need shapes (n,) and (n, 3), not {due_ns.shape}, {steps.shape}")
    if due_ns.dtype.kind != "i" or steps.dtype.kind != "i":
        raise ValueError(f"ticks must be whole numbers, not {due_ns.dtype} and {steps.dtype}")
    if np.abs(steps).max(initial=0) > 1:
        raise ValueError("a tick steps each motor by -1, 0 or +1")
    codes = (steps != 0) @ _STEPPING | (steps < 0) @ _NEGATIVE
    return due_ns.astype(np.int64, copy=False), codes


def as_steps(codes: Codes) -> Int8Array:
    """Steps of shape (n, 3), each -1, 0 or +1."""
    steps: Int8Array = _STEPS_OF[codes & 0b111111]
    return steps


def stepping(codes: Codes) -> BoolArray:
    """Which codes step a motor; shape (n,)."""
    moves: BoolArray = (codes & 0b111) != 0
    return moves
