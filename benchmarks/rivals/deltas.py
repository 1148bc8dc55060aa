"""Drawn deltas that every tool gets, and how their answers are scored.

The proof's generator draws the machines and MuJoCo moves them, which no tool's kinematics share.
Half are healthy; the others hide one to three effects that have a name (groups single, two and
three).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from benchmarks.rivals.cases import (
    ROBOT_JSON,
    Answers,
    Scored,
    in_place,
    in_places,
    write_names,
)
from deltactl.proof.cases import ROUND, Case, draw, write_blind
from deltactl.proof.prove.one_case import as_recorded, bound
from deltactl.proof.ranging import NOMINAL_OFFSET_M
from deltactl.proof.robot.as_built import Body, Joints
from deltactl.proof.robot.bodies import build

Json = dict[str, Any]
NAMED_GROUPS = ("single", "two", "three")
SEED_FROM = 46_000
"""Seeds of the generator that nothing else draws from."""
ROUNDING_M = 1e-3
GROUP = "deltas"
HEAVY_KGM2, STEP_S = 0.2, 0.004
"""A hub and a step of simulation that suit each other; see delta_sysid.py."""


def write_deltas(count: int, seed: int, folder: Path) -> list[Json]:
    """A folder a delta, every other one healthy. Returns the truths, which no tool sees."""
    own_seed = SEED_FROM + seed
    healthy, faulty = _drawn(own_seed, ("nothing",)), _drawn(own_seed, NAMED_GROUPS)
    truths = []
    for number in range(count):
        case = next(faulty if number % 2 else healthy)
        truth = case.truth()
        own = folder / truth["case"]
        run = write_blind(case, own, own_seed)
        (own / ROBOT_JSON).write_text(json.dumps(robot_values()), encoding="utf-8")
        truth["bound"] = bound(case, as_recorded(case, run)) if case.group == "single" else None
        truths.append(truth)
    write_names(truths, folder)
    write_bodies(folder.with_name(f"{folder.name}-robot.xml"))
    return truths


def write_bodies(file: Path) -> None:
    """The healthy robot for a tool that simulates it, with a sensor at its platform."""
    model = build(Body(), Joints(hub_kgm2=HEAVY_KGM2), STEP_S)
    mujoco.mj_saveLastXML(str(file), model)
    text = file.read_text(encoding="utf-8")
    # Rounded in the file, the inertia of a thin plate is less than possible.
    text = text.replace("<compiler ", '<compiler balanceinertia="true" ', 1)
    seen = '<sensor><framepos name="at" objtype="xbody" objname="platform"/></sensor>'
    file.write_text(text.replace("</mujoco>", f"{seen}</mujoco>"), encoding="utf-8")


def _drawn(seed: int, groups: Sequence[str]) -> Iterator[Case]:
    number = 0
    while True:
        if ROUND[number % len(ROUND)] in groups:
            yield draw(seed, number)
        number += 1


def robot_values() -> Json:
    """What the robot file states, in SI units."""
    body = Body()
    return {
        "base_radius_m": float(body.base_radius_m[0]),
        "platform_radius_m": float(body.platform_radius_m[0]),
        "upper_arm_m": float(body.upper_arm_m[0]),
        "forearm_m": float(body.forearm_m[0]),
        "azimuth_rad": body.azimuth_rad.tolist(),
        "rad_per_step": Joints().rad_per_step,
        "sensor_m": list(NOMINAL_OFFSET_M),
    }


def scored_deltas(truths: Sequence[Json], answers: Answers) -> list[Scored]:
    """Right: the findings are the hidden effects in their places, no more and no less."""
    found = []
    for truth in truths:
        own = answers.by_case[truth["case"]]
        if own["seconds"] is None:
            continue
        hidden, said = in_places(truth, own)
        covered, over = [], []
        for name, line in hidden.items():
            if name in said:
                sizes = list(_held(line, said[name]["parameters"], truth["bound"] or {}))
                covered += [inside for inside, _ in sizes]
                over += [error for _, error in sizes if np.isfinite(error)]
        noise = float(np.hypot(truth["sigma"], ROUNDING_M / np.sqrt(12.0)))
        over_noise = np.nan if own["heldout"] is None else own["heldout"] / noise
        figures = {"sizes": covered, "over_bound": over, "heldout_over_noise": over_noise}
        found.append(in_place(GROUP, truth, answers, hidden, said, **figures))
    return found


def _held(line: Json, sizes: Json, deviations: Json) -> Iterator[tuple[bool, float]]:
    """For each known size that is stated: inside its interval, and its error over the bound."""
    for name, true in line["parameters"].items():
        stated = sizes.get(name)
        if stated is None or stated["value"] is None or (name == "time" and "when" in line):
            continue
        values, wanted = np.atleast_1d(stated["value"]), np.atleast_1d(true)
        ends = np.array(stated["ci95"], dtype=np.float64).reshape(-1, 2)
        least = np.broadcast_to(deviations.get(name, np.nan), values.shape)
        for value, want, (low, high), least_one in zip(values, wanted, ends, least, strict=True):
            yield bool(low <= want <= high), float(abs(value - want) / least_one)
