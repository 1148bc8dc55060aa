"""Scores the diagnosis on the practice recordings; only this file reads the answers.

    python benchmarks/proofs/diagnosis_practice.py [--recordings DIR] [--processes N] [CASE ...]

DIR is the folder `recordings` of the project's shared material: --recordings, or environment
variable DELTACTL_RECORDINGS, or ../shared/recordings beside the repository.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from deltactl.diagnosis.api import diagnose
from deltactl.models.effects import effect_kind

DEFAULT = Path(__file__).resolve().parents[2] / "../shared/recordings"
Case = dict[str, Any]


def recordings_folder(given: str | None) -> Path:
    """Where the recordings are."""
    return Path(given or os.environ.get("DELTACTL_RECORDINGS") or DEFAULT) / "practice"


def run_case(folder: Path, answer: Case) -> Case:
    """Diagnose one case blind."""
    case = folder / answer["case"]
    start = time.perf_counter()
    result = diagnose(
        [case / "recording.csv.gz"], folder / "robot.yaml", [case / "holdout.csv.gz"]
    ).to_json()
    return {"seconds": time.perf_counter() - start, "result": result, **answer}


def judge(case: Case) -> str:
    """exact, first, alternative, silent, false alarm, unknown, misnamed or missed."""
    truth = {(a["effect"], a["where"]) for a in case["answers"]}
    found = [(f["effect"], f["component"]) for f in case["result"]["findings"]]
    if not truth:
        return "false alarm" if found else "silent"
    if not found:
        return "missed"
    if any(effect == "unknown" for effect, _ in truth):
        return _judge_unknown(case)
    if set(found) == truth:
        return "exact"
    if found[0] in truth:
        return "first" if len(truth) == 1 else "first of several"
    others = {
        (a["effect"], a["component"]) for f in case["result"]["findings"] for a in f["alternatives"]
    }
    return "alternative" if truth & (others | set(found)) else "misnamed"


def _judge_unknown(case: Case) -> str:
    first = case["result"]["findings"][0]
    if first["effect"] != "unknown":
        return "misnamed"
    driver = first["depends_on"]
    right = driver and driver[0] == case["answers"][0]["depends_on"]
    return "unknown, right driver" if right else "unknown"


def sizes(case: Case) -> str:
    """Found main parameter with its interval against the truth."""
    parts = []
    for answer in case["answers"]:
        for finding in case["result"]["findings"]:
            if (finding["effect"], finding["component"]) != (answer["effect"], answer["where"]):
                continue
            size = finding["parameters"][effect_kind(answer["effect"]).main.name]
            low, high = size["ci95"][0], size["ci95"][-1]
            value, truth = size["value"], answer["value"]
            if isinstance(value, float) and isinstance(truth, float | int):
                inside = "in" if low <= truth <= high else "OUT"
                parts.append(f"{value:.5g} [{low:.5g}, {high:.5g}] true {truth:.5g} {inside}")
    return "; ".join(parts)


def _in_words(finding: Case) -> str:
    name = f"{finding['effect']}@{finding['component']}"
    follows = f"({'/'.join(finding['depends_on'])})" if finding["depends_on"] else ""
    others = ", ".join(f"{a['effect']}@{a['component']}" for a in finding["alternatives"])
    return name + follows + (f" (or {others})" if others else "")


def row(case: Case) -> str:
    """One line of the table."""
    fit = case["result"]["fit"]
    found = ", ".join(_in_words(finding) for finding in case["result"]["findings"])
    truth = ", ".join(f"{a['effect']}@{a['where']}" for a in case["answers"]) or "nothing"
    gain = (
        f"{1e3 * fit['holdout_rms_before_m']:5.2f} {1e3 * fit['holdout_rms_after_m']:5.2f} "
        f"{1e3 * fit['noise_floor_m']:5.2f}"
    )
    return (
        f"{case['case']} {judge(case):22s} p={case['result']['false_alarm_p']:.2g} "
        f"{case['result']['verdict']:17s} [{gain}] {case['seconds']:4.1f} s\n"
        f"      truth {truth}\n      found {found or 'nothing'}\n      {sizes(case)}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--recordings")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    folder = recordings_folder(options.recordings)
    if not (folder / "answers.json").exists():
        print(f"{folder}: not there; name the recordings with --recordings", file=sys.stderr)
        return 2
    answers = json.loads((folder / "answers.json").read_text())
    chosen = [a for a in answers if not options.cases or a["case"][5:] in options.cases]
    counts: dict[str, int] = {}
    print("held-out RMS before, after, and noise floor in [] (mm)")
    with ProcessPoolExecutor(options.processes) as pool:
        for case in pool.map(partial(run_case, folder), chosen):
            counts[judge(case)] = counts.get(judge(case), 0) + 1
            print(row(case), flush=True)
    print(", ".join(f"{name}: {count}" for name, count in sorted(counts.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
