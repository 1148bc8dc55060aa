"""Headings of several motors with the number inside a name: q1_ref, joint_2_cmd, ref_q1."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.names import read_name
from deltactl.recording.foreign.reading import read_mapped
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
T_S = 0.02 * np.arange(600)
ASKED_RAD = [0.2 * np.sin(1.3 * T_S + phase) + 0.1 * np.sin(0.7 * T_S) for phase in (0.0, 2.0, 4.0)]
SEEN_RAD = [
    asked + 2e-3 * np.random.default_rng(arm).standard_normal(len(T_S))
    for arm, asked in enumerate(ASKED_RAD)
]
NUMBERS = (1, 2, 3)

SIZES_MM = {"base-radius": "122", "platform-radius": "100", "upper-arm": "314", "forearm": "587"}


def write(path: Path, asked: str, seen: str, motors: tuple[int, ...] = NUMBERS) -> Path:
    """A table in ms and degrees; `asked` and `seen` name the columns of motor {n}."""
    names = ["ms", *(name.format(n=n) for name in (asked, seen) for n in motors)]
    angles = [values[(n - 1) % 3] for values in (ASKED_RAD, SEEN_RAD) for n in motors]
    rows = np.stack([1e3 * T_S, *np.degrees(angles)], axis=1)
    np.savetxt(path, rows, "%.4f", ",", header=",".join(names), comments="")
    return path


@pytest.mark.parametrize(
    ("asked", "seen"),
    [
        ("q{n}_ref", "q{n}"), ("q{n}_cmd", "q{n}_act"), ("j{n}_des", "j{n}_pos"),
        ("ref_q{n}", "q{n}"), ("joint_{n}_target", "joint_{n}_position"),
        ("q{n}_ref_deg", "q{n}_meas_deg"),
    ],
)  # fmt: skip
def test_three_arms_are_a_delta_wherever_their_number_stands(
    tmp_path: Path, asked: str, seen: str
) -> None:
    path = write(tmp_path / "a.csv", asked, seen)
    found = inspect(path)
    assert found.kind == "delta"
    read = read_mapped(path, load_mapping(None, owner_says(found)))
    for n in NUMBERS:
        np.testing.assert_allclose(read.column(f"command_{n}"), ASKED_RAD[n - 1], atol=1e-5)
        np.testing.assert_allclose(read.column(f"theta_{n}"), SEEN_RAD[n - 1], atol=1e-5)


@pytest.mark.parametrize(
    ("name", "role", "index"),
    [("q1_error", None, None), ("q10_ref", "command", None), ("x_ref", "command", None)],
)
def test_other_names_have_no_number(name: str, role: str | None, index: str | None) -> None:
    named = read_name(name)
    assert (named.role, named.index) == (role, index)


def test_of_six_joints_the_first_is_one_axis(tmp_path: Path) -> None:
    found = inspect(write(tmp_path / "a.csv", "q{n}_ref", "q{n}", (1, 2, 3, 4, 5, 6)))
    taken = {guess.name: guess.source for guess in found.guesses.values()}
    assert found.kind == "servo_axis"
    assert taken == {"t": "ms", "command": "q1_ref", "position": "q1"}


@pytest.mark.study
def test_the_commands_that_are_printed_work(tmp_path: Path, deltactl: Deltactl) -> None:
    write(tmp_path / "delta.csv", "q{n}_ref", "q{n}")
    shown = deltactl("inspect", "delta.csv").stdout
    _, init, *read = shlex.split(re.findall(r"describe the machine: +(.*)", shown)[0])
    sizes = [word for name, mm in SIZES_MM.items() for word in (f"--{name}-mm", mm)]
    deltactl(init, *read, *sizes, "--gear-ratio", "1")
    _, *diagnose = shlex.split(re.findall(r"diagnose it: +(.*)", shown)[0])
    answer = json.loads(deltactl(*diagnose, "--json", "-").stdout)
    assert (answer["verdict"], answer["findings"]) == ("nothing_missing", [])


def test_nothing_stands_in_for_an_arm_of_several(tmp_path: Path) -> None:
    path = write(tmp_path / "delta.csv", "q{n}_ref", "q{n}")
    wrong = load_mapping(None, ["t=ms[ms]", "command_1=q1_ref[deg]", "theta_1=q9[deg]"])
    with pytest.raises(RecordingError, match=r"'q9' \(for theta_1\) is missing; did you mean 'q1'"):
        read_mapped(path, wrong)
