"""A short fuzzing: the long one is benchmarks/endurance/fuzz.py."""

from __future__ import annotations

import random

import pytest

from benchmarks.endurance.fuzz_targets import OURS, TARGETS, mutated

INPUTS = {"job": 150, "socket": 150, "recording": 250, "values": 60, "model": 100, "csv": 250}


@pytest.mark.parametrize("name", TARGETS)
def test_only_errors_of_ours(name: str) -> None:
    fuzzed, chance = TARGETS[name](), random.Random(name)
    said: list[str] = []
    taken = 0
    for data in (*fuzzed.seeds, *(mutated(fuzzed, chance) for _ in range(INPUTS[name]))):
        try:
            fuzzed.run(data)
            taken += 1
        except OURS as error:
            said += [str(line) for line in error.args] or [str(error)]
    assert not any("\n" in text for text in said)
    assert taken > 0, "nothing was taken: the seeds are broken"
    assert name == "socket" or len(said) > 10
