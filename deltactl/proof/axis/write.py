"""A case on disk: robot file and two recordings for the diagnosis, the truth for the scorer."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from deltactl.foundation.plain_file import write_whole
from deltactl.proof.axis.build import Design, Run
from deltactl.proof.axis.cases import AxisCase
from deltactl.proof.axis.commanded import CommandedAxis
from deltactl.proof.axis.forced import ForcedAxis
from deltactl.proof.axis.motions import FloatArray
from deltactl.recording.tables.flat import from_columns
from deltactl.recording.tables.flat_files import write_flat

RECORDING, HOLDOUT, ROBOT_FILE = "recording.csv.gz", "holdout.csv.gz", "robot.yaml"
DIGITS = 9


def write_blind(case: AxisCase, folder: Path) -> None:
    """What the diagnosis may see: no word of what is hidden."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([case.seed, 43])
    for run, name in ((case.run, RECORDING), (case.holdout, HOLDOUT)):
        write_flat(from_columns(table(case, run, rng), name), folder / name)
    write_whole(folder / ROBOT_FILE, robot_file(case.design))


def write_answers(case: AxisCase, path: Path) -> None:
    """The truth, as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(case.truth(), indent=1) + "\n")


def table(case: AxisCase, run: Run, rng: np.random.Generator) -> dict[str, FloatArray]:
    """The columns of one recording."""
    plan, rows = case.design, run.rows
    once = case.sizes if run is case.run else {
        name: values for name, values in case.sizes.items() if name != "lost_steps"
    }  # fmt: skip
    columns = {"t": rows.stamp_s}
    if isinstance(run.axis, ForcedAxis):
        at, speed, asked = run.axis.recorded(rows.true_s)
        read = plan.noise.read(at, rng)
        columns["position"] = read[rows.shown]
        columns["effort"] = plan.effort_noise.read(asked, rng) / plan.gain
        if plan.speed_column:
            rough = 3.0 * plan.noise.scatter / plan.pace.stroke_s
            columns["velocity"] = speed + rough * rng.standard_normal(len(speed))
        if plan.loaded:
            columns["load"] = np.interp(rows.true_s, run.motion.t_s, run.axis.load)
        return _rounded(columns)
    clean = run.axis.clean(once, rows.true_s)
    read = plan.noise.read(clean, rng)[rows.shown]
    if isinstance(run.axis, CommandedAxis):
        turns = "command_1" if plan.names == "theta_1" else "command"
        columns["steps_1" if plan.counted else turns] = run.axis.command(rows.true_s)
        columns["theta_1" if plan.counted else plan.names] = read
        if plan.loaded:
            columns["load"] = np.interp(rows.true_s, run.motion.t_s, run.axis.load)
    else:
        columns["distance"] = run.motion.at(rows.true_s)
        columns["range"] = read
    return _rounded(columns)


def _rounded(columns: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Written with as many digits as a log has."""
    return {
        name: np.array([float(f"{value:.{DIGITS}g}") for value in values])
        for name, values in columns.items()
    }


def robot_file(plan: Design) -> str:
    """What the machine was meant to be."""
    if plan.machine == "range":
        return "kind: range_sensor\nname: proof-sensor\n"
    zero = "absolute" if plan.absolute else "arbitrary"
    if plan.counted:
        # rad per microstep = 2 pi / (microsteps_per_rev * gear_ratio)
        gear = 2.0 * np.pi / (plan.step_size * 3200.0)
        drive = f"drive: {{microsteps_per_rev: 3200, gear_ratio: {gear:.10g}}}\n"
        return f"kind: stepper_axis\nname: proof-axis\nzero: {zero}\n{drive}"
    motion = "linear" if plan.linear else "rotary"
    text = f"kind: servo_axis\nname: proof-axis\nmotion: {motion}\n"
    if plan.machine == "commanded":
        return text + f"zero: {zero}\n"
    text += f"inertia: {plan.inertia:.10g}\neffort_gain: {plan.gain:.10g}\n"
    if not plan.states_gravity:
        return text
    if plan.linear:
        return text + f"gravity: {{force_n: {plan.weight:.10g}}}\n"
    torque, zero_rad = plan.gravity
    return text + f"gravity: {{torque_nm: {torque:.10g}, zero_rad: {zero_rad:.10g}}}\n"
