"""Real recordings of single axes, sensors and arms, and what is known of their machines.

A folder holds folders, each with `robot.yaml`, recordings and `expected.json`: recording ->
`expected` (effects with a `range` or a `tolerance` of a `value`), `must_not_claim` (an effect, with
"over SIZE UNIT" only from that size on, with "as the main effect" only as the first finding), and
`rms_with_effect`, what the known effects leave. Nothing of it is copied but into --out.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks.rivals.arm_signals import URDF
from benchmarks.rivals.cases import ROBOT_JSON, Answers, Scored, agreement
from deltactl.proof.cases import HOLDOUT, RECORDING, ROBOT_FILE
from deltactl.proof.prove.table import gathered
from deltactl.recording.tables.flat_files import read_flat

Json = dict[str, Any]
EXPECTED = "expected.json"
SINGLE = ("servo_axis", "stepper_axis", "range_sensor")
ARMS = ("chain",)
ONE_PLACE = {"axis", "motor1", "joints", "sensor", None}
"""Places of the only axis of a machine."""
UNITS = {"um": 1e-6, "mrad": 1e-3, "rad": 1.0, "m": 1.0, "s": 1.0}
CLAIM = re.compile(r"([a-z_]+)(?: over ([\d.]+) ?(um|mrad|rad|m|s)\b)?")
QUALIFIED = re.compile(r"alone|beyond|except|instead|interval|refused")
"""Words of a condition that no list of names can meet or break."""
SIZES = ("time", "dead_time", "amplitude", "angle", "width", "offset")
RATIO_NEAR_ONE = 0.01
GROUP = "real recordings"


def write_real(
    given: Path, folder: Path, kinds: Sequence[str] = SINGLE
) -> tuple[list[Json], list[str]]:
    """A case a recording: what is known of each, and what is left out and why."""
    if not given.is_dir():
        return [], [f"real recordings: {given} is no folder"]
    known, skipped = [], []
    for own in sorted(file.parent for file in given.glob(f"*/{EXPECTED}")):
        robot = yaml.safe_load((own / ROBOT_FILE).read_text(encoding="utf-8"))
        if robot["kind"] not in kinds:
            skipped.append(f"{own.name}: kind {robot['kind']}, not {' or '.join(kinds)}")
            continue
        expected = json.loads((own / EXPECTED).read_text(encoding="utf-8"))
        for name, answer in expected.items():
            if name.startswith("_"):
                continue
            if not (own / name).exists():
                skipped.append(f"{own.name}/{name}: no such file")
                continue
            case = f"{own.name}__{name.split('.')[0]}"
            known.append({"case": case} | answer | _write(own, name, answer, robot, folder / case))
    if not known:
        skipped.append(f"real recordings: {given} has no {EXPECTED} of {' or '.join(kinds)}")
    return known, skipped


def _write(own: Path, name: str, answer: Json, robot: Json, case: Path) -> Json:
    case.mkdir(parents=True)
    shutil.copy(own / name, case / RECORDING)
    shutil.copy(own / ROBOT_FILE, case / ROBOT_FILE)
    apart = own / str(answer.get("holdout"))
    if apart.is_file():
        shutil.copy(apart, case / HOLDOUT)
    if robot["kind"] in ARMS:
        shutil.copy(own / robot["model"], case / robot["model"])
        shutil.copy(own / robot["model"], case / URDF)
        values = {"joints": robot["joints"], "effort_gain": robot["effort_gain"]}
    else:
        values = robot_values(robot, set(read_flat(own / name).columns))
    (case / ROBOT_JSON).write_text(json.dumps(values), encoding="utf-8")
    return {"forced": "step" not in values}


def robot_values(robot: Json, columns: set[str]) -> Json:
    """As `cases.robot_values`, of a robot file; `sensor` marks a range sensor."""
    if "effort" in columns:
        gravity = robot.get("gravity") or {}
        return {
            "inertia": robot["inertia"],
            "gain": robot.get("effort_gain", 1.0),
            "weight": gravity.get("force_n", 0.0),
            "gravity": gravity.get("torque_nm", 0.0),
            "gravity_zero": gravity.get("zero_rad", 0.0),
        }
    drive, step = robot.get("drive"), 1.0
    if drive and "steps_1" in columns:
        step = 2.0 * np.pi / (drive["microsteps_per_rev"] * drive["gear_ratio"])
    zero = robot.get("zero", "absolute")
    return {"zero": zero, "step": step, "sensor": robot["kind"] == "range_sensor"}


def judged(known: Sequence[Json], answers: Answers, group: str = GROUP) -> list[Scored]:
    """Every recording that the tool takes.

    Right: each expected effect is a finding whose size is in its range, or an alternative of a
    finding (play and friction give the same positions), and nothing is claimed that must not be.
    """
    taken = [one for one in known if answers.by_case[one["case"]]["seconds"] is not None]
    return [_scored(one, answers, group) for one in taken]


@dataclass(frozen=True, slots=True)
class Met:
    """What findings say of one expected effect."""

    found: bool
    offered: bool
    """Found, or among the alternatives."""
    in_range: bool | None
    """Whether a size that is stated is in its range; None without one."""


def _met(part: Json, findings: Sequence[Json]) -> Met:
    hits = [finding for finding in findings if same(part, finding)]
    others = gathered(findings, lambda finding: finding["alternatives"])
    stated = [ok for finding in hits if (ok := in_range(part, finding)) is not None]
    offered = any(same(part, one) for one in (*hits, *others))
    return Met(bool(hits), offered, any(stated) if stated else None)


def _scored(one: Json, answers: Answers, group: str) -> Scored:
    own = answers.by_case[one["case"]]
    findings = (own["diagnosis"] or {"findings": []})["findings"]
    met = [_met(part, findings) for part in one["expected"]]
    false = any(claims(text, findings, one) for text in one.get("must_not_claim") or [])
    sizes = [part.in_range for part in met if part.in_range is not None]
    fits = not false and all(sizes) and own["failure"] is None
    return Scored(
        one["case"],
        group,
        [part["effect"] for part in one["expected"]],
        [finding["effect"] for finding in findings],
        fits and all(part.offered for part in met),
        false,
        own["seconds"],
        own["failure"],
        sizes,
        heldout_over_noise=_over_noise(one, own["heldout"]),
        agree=agreement(answers, one["case"]),
        outright=fits and all(part.found for part in met),
    )


def _over_noise(one: Json, heldout: float | None) -> float:
    """Held-out error over what the known effects leave, where there is such a figure."""
    if heldout is None or one["forced"] or not one.get("rms_with_effect"):
        return float("nan")
    return float(heldout / one["rms_with_effect"])


def same(part: Json, finding: Json) -> bool:
    """Whether a finding or an alternative is an expected effect, in its place if it says one."""
    where, said = part.get("component"), finding.get("component")
    one = where in ONE_PLACE and said in ONE_PLACE
    return bool(part["effect"] == finding["effect"]) and (where == said or said is None or one)


def in_range(part: Json, finding: Json) -> bool | None:
    """Whether the size of a finding is in the range of the expected effect, of either sign.

    None for an effect without a range or a finding without a size. A wave must have its period
    too. A lag is its time constant and its dead time together.
    """
    sizes = {name: size["value"] for name, size in finding["parameters"].items()}
    if part.get("period_deg") and sizes.get("period") is not None:
        period = sizes["period"]
        off = abs(period / np.radians(part["period_deg"]) - 1.0)
        if off > part.get("period_tolerance", 0.05):
            return False
    if part["effect"] == "following_lag":
        value = sum(v for n, v in sizes.items() if n in ("time", "dead_time") and v is not None)
    else:
        value = sizes.get(part.get("parameter", ""))
    low, high = _range(part)
    if value is None or not sizes or not np.isfinite(high - low):
        return None
    return bool(low <= value <= high or low <= abs(value) <= high)


def _range(part: Json) -> tuple[float, float]:
    if part.get("range"):
        return part["range"][0], part["range"][1]
    if part.get("tolerance") and part.get("value") is not None:
        return part["value"] - part["tolerance"], part["value"] + part["tolerance"]
    return -np.inf, np.inf


def _claimed_under(text: str, finding: Json, first: Json) -> bool | None:
    """Whether a finding meets the condition in what must not be claimed; None without one."""
    if " as the main" in text:
        return finding is first
    if " without " in text:
        other = text.split(" without ")[1].split()[0]
        return other not in [one["effect"] for one in finding["alternatives"]]
    if "(a ratio of" in text:
        scale = finding["parameters"].get("scale", {}).get("value")
        return scale is None or abs(scale - 1.0) > RATIO_NEAR_ONE
    return None


def claims(text: str, findings: Sequence[Json], one: Json) -> bool:
    """Whether findings claim what must not be claimed."""
    words = CLAIM.match(text)
    if words is None:
        return False
    effect, limit, unit = words.groups()
    own = [finding for finding in findings if finding["effect"] == effect]
    under = [_claimed_under(text, finding, findings[0]) for finding in own]
    if None not in under:
        return any(under)
    if limit is None and QUALIFIED.search(text):
        return False
    own = [finding for finding in own if not any(same(part, finding) for part in one["expected"])]
    if limit is None:
        return bool(own)
    most = float(limit) * UNITS[unit]
    return any(abs(value) > most for finding in own for value in _values(finding))


def _values(finding: Json) -> Iterator[float]:
    for name, size in finding["parameters"].items():
        if name in SIZES and isinstance(size["value"], float):
            yield size["value"]
