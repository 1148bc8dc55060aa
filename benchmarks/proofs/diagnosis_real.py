"""What the diagnosis finds on real recordings of others: sizes, and RMS on data it has not seen.

    python benchmarks/proofs/diagnosis_real.py [--recordings DIR] [SET ...]

DIR is the folder `recordings` of the project's shared material (see diagnosis_practice.py). The
robot files there are naive on purpose; docs/proof.md says what comes out and what was published.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from pathlib import Path

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose, diagnose_recordings
from deltactl.models.robot import RangeSensor
from deltactl.recording.foreign.mapping import Mapping, load_mapping
from deltactl.recording.foreign.reading import read_mapped

DEFAULT = Path(__file__).resolve().parents[2] / "../shared/recordings"
ARMS = {
    "elbow": "single_joint_elbow",
    "pitch": "single_joint_elbow",
    "rotation": "sinusoidal_sweep",
    "wrist_roll": "triangle_wave",
}
RUNS: list[tuple[str, str, str | None]] = [
    ("emps", "emps", None),
    ("vactank", "run_at_30deg", "run_at_10deg"),
    ("vactank", "run_at_10deg", "run_at_30deg"),
    ("vactank", "earlier_run", None),
    ("ess_target_x", "laser", "laser_holdout"),
    ("ess_target_x", "resolver", "resolver_holdout"),
    ("telescope_worm", "astrophysics_gto_a", "astrophysics_gto_a_holdout"),
    ("telescope_worm", "losmandy_g11", "losmandy_g11_holdout"),
    ("ur10e_joint6", "joint_alone", "joint_alone_holdout"),
    ("ur10e_joint6", "exciting_all_joints", "exciting_all_joints_holdout"),
    ("sts3215_backlash", "single_servo", None),
    ("sts3215_backlash", "dual_preloaded", None),
    ("servo_pendulum_gain8", "sin_sin_gain8", "up_and_down_gain8"),
    ("servo_pendulum_gain8", "sin_time_square_gain8", "sin_sin_gain8"),
    ("servo_pendulum_gain8", "up_and_down_gain8", "sin_sin_gain8"),
    ("uwb_rooms", "room_hw", None),
    *[(f"so101_sage_{joint}", other, "small_moves") for joint, other in ARMS.items()],
    *[(f"so101_sage_{joint}", "small_moves", other) for joint, other in ARMS.items()],
    ("taarlab_tracking", "cycle_4s_ptp_polynomial5th", "cycle_4s_ptp_bangbang"),
    ("taarlab_tracking", "cycle_6s_ptp_trapezoidal", "cycle_2s_ptp_polynomial7th"),
]
SENSOR = RangeSensor(kind="range_sensor", name="vl53l0x")
STATIC = ("range=d[mm]", "distance=0.076", "rate_hz=50")
TABLES: list[tuple[str, Mapping]] = [
    (
        "calibration_table.csv",
        load_mapping(None, ("distance=true_mm[mm]", "range=measured_mm[mm]", "rate_hz=1")),
    ),
    *[
        (
            f"static_tof_dist_data_{hours}_h.csv.gz",
            load_mapping(None, STATIC).model_copy(update={"skip_lines": 2}),
        )
        for hours in (1, 4)
    ],
]


def answers(folder: Path, wanted: list[str]) -> Iterator[tuple[str, Diagnosis, float]]:
    """Name, answer and seconds of every run."""
    for case, recording, holdout in RUNS:
        if wanted and case not in wanted:
            continue
        start = time.perf_counter()
        others = [folder / case / f"{holdout}.csv.gz"] if holdout else []
        answer = diagnose(
            [folder / case / f"{recording}.csv.gz"], folder / case / "robot.yaml", others
        )
        yield f"{case}/{recording}", answer, time.perf_counter() - start
    for table, mapping in TABLES:
        if wanted and "tof_vl53l0x" not in wanted:
            continue
        start = time.perf_counter()
        answer = diagnose_recordings(SENSOR, [read_mapped(folder / "tof_vl53l0x" / table, mapping)])
        yield f"tof_vl53l0x/{table}", answer, time.perf_counter() - start


def show(name: str, answer: Diagnosis, seconds: float) -> None:
    """One recording's rows of the table."""
    fit = answer.fit
    print(
        f"{name}  [{answer.verdict}, {seconds:.1f} s]\n  held out ({fit.holdout}) "
        f"{fit.holdout_rms_before_m:.3g} -> {fit.holdout_rms_after_m:.3g} {fit.unit}, "
        f"noise floor {fit.noise_floor_m:.3g} {fit.unit}"
    )
    for finding in answer.findings:
        sizes = "; ".join(
            f"{key} {size.value:.4g} [{size.ci95[0]:.4g}, {size.ci95[1]:.4g}] {size.unit}"
            for key, size in finding.parameters.items()
            if isinstance(size.value, float)
        )
        follows = f" follows {', '.join(finding.depends_on)}" if finding.depends_on else ""
        others = ", ".join(a.effect for a in finding.alternatives)
        print(
            f"    {finding.effect} @ {finding.component}{follows}: {sizes}"
            + (f"   (or {others})" if others else "")
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--recordings")
    parser.add_argument("sets", nargs="*")
    options = parser.parse_args()
    folder = Path(options.recordings or os.environ.get("DELTACTL_RECORDINGS") or DEFAULT)
    for row in answers(folder, options.sets):
        show(*row)


if __name__ == "__main__":
    main()
