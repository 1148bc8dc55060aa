"""Arms by a textbook's inverse dynamic model and by FIGAROH 1.0.

Imports nothing of deltactl; `arm_signals.py` says what both read.

Protocol. Each tool gets the URDF, with the friction that it states, and what one unit of effort is.
Both know what a drawing leaves open: a size below a fiftieth of the root mean square of its joint's
effort, or of the mass of all links, is no name, nor a friction, rotor or lag below zero, nor a lag
under a quarter of the rows' period.

textbook: weighted least squares of the efforts that the links of the URDF leave (Pinocchio's
regressor), each joint weighted by its own residual. Columns of each joint: sign v, v, a, 1, the
drive that the model asks for (`effort_gain`) and the slope of the effort (`following_lag`); of the
last link a mass with its moments and inertias (`payload`). Rows are thinned to the low-pass, and
standard errors are widened by the correlation of what is left. The least sure column is dropped
until every one has |t| > 4, the payload by its mass. A column left is a name; intervals are 1.96
standard errors.

FIGAROH: its `BaseIdentification` with friction, rotor inertia and offset of each joint, base
parameters by its double QR, weighted least squares by its Gautier weights. A parameter of friction,
rotor or offset is a name where its base parameter differs from the URDF's by |t| > 4, errors
widened likewise; a payload where such columns of the last link, fitted to the other base
parameters, have |t| > 4 of the mass. It has no name for gains and lags.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import logging
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rivals.arm_signals import (
    SURE_T,
    ArmRun,
    arm_finding,
    arm_signals,
    sureness,
    widening,
)
from benchmarks.rivals.axis_signals import Array, Json, rate

ROUNDS = 3
"""Weighted fits, each with the weights of the one before."""
FIGAROH_NAMES = {
    "fs": "joint_friction",
    "fv": "viscous_friction",
    "Ia": "inertia",
    "off": "effort_offset",
}
LINK = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Mass, moments and inertias of a link, in the order of a regressor."""
Column = tuple[str, str]
"""Effect and place; what a payload has beside its mass has the effect 'moment'."""


def links(run: ArmRun, rows: Any) -> tuple[Array, Array]:
    """Efforts (n, joints) of all links, and the regressor (n, joints, 10) of the last one."""
    pin: Any = importlib.import_module("pinocchio")
    model = pin.buildModelFromUrdf(str(run.urdf))
    data = model.createData()
    own = np.concatenate([inertia.toDynamicParameters() for inertia in model.inertias[1:]])
    asked, last = [], []
    for q, v, a in zip(run.q[rows], run.v[rows], run.a[rows], strict=True):
        table = pin.computeJointTorqueRegressor(model, data, q, v, a)
        asked.append(table @ own)
        last.append(table[:, -10:])
    return np.array(asked), np.array(last)


def _columns(run: ArmRun, rows: Any) -> tuple[Array, dict[Column, Array]]:
    """What the URDF asks for, and columns of what may be beside it, all (n, joints)."""
    asked, last = links(run, rows)
    v, a = run.v[rows], run.a[rows]
    asked = asked + run.dry * np.sign(v) + run.viscous * v
    slope = np.column_stack([rate(column, run.step_s) for column in run.effort.T])[rows]
    made: dict[Column, Array] = {}
    for j, name in enumerate(run.joints):
        of_joint = {
            "joint_friction": np.sign(v),
            "viscous_friction": v,
            "inertia": a,
            "effort_offset": np.ones_like(v),
            "effort_gain": asked,
            "following_lag": slope,
        }
        for effect, signal in of_joint.items():
            made[effect, name] = np.zeros_like(v)
            made[effect, name][:, j] = signal[:, j]
    for place, column in zip((run.tip, *LINK[1:]), np.moveaxis(last, 2, 0), strict=True):
        made["payload" if place == run.tip else "moment", place] = column
    return asked, made


def by_textbook(run: ArmRun) -> list[Json]:
    """Findings."""
    asked, columns = _columns(run, run.rows)
    rest, kept = run.effort[run.rows] - asked, dict(columns)
    while kept:
        terms, errors = _fitted(rest, list(kept.values()))
        found = {name: pair for *pair, name in zip(terms, errors, kept, strict=True)}
        sure = {
            name: sureness(run, name, *pair) for name, pair in found.items() if name[0] != "moment"
        }
        worst = min(sure, key=lambda name: sure[name])
        if sure[worst] > SURE_T:
            return list(_sized(found))
        del kept[worst]
        if worst[0] == "payload":
            kept = {name: column for name, column in kept.items() if name[0] != "moment"}
    return []


def _sized(found: dict[Column, list[float]]) -> Iterator[Json]:
    """A drive of g times its effort needs 1/g of what the model asks for and of each term."""
    for (effect, place), (term, error) in found.items():
        gain = 1.0 / (1.0 + found.get(("effort_gain", place), [0.0, 0.0])[0])
        if effect == "effort_gain":
            yield arm_finding(effect, place, gain, 1.96 * error * gain**2)
        elif effect in ("payload", "following_lag"):
            yield arm_finding(effect, place, term, 1.96 * error)
        elif effect != "moment":
            yield arm_finding(effect, place, gain * term, 1.96 * gain * error)


def _fitted(rest: Array, columns: list[Array]) -> tuple[Array, Array]:
    """Terms of the columns (n, joints), weighted by the residual of each joint, and errors."""
    weight = np.ones(rest.shape[1])
    for _ in range(ROUNDS):
        table = np.column_stack([(column * weight).ravel() for column in columns])
        units = np.sqrt(np.mean(table**2, axis=0)) + 1e-300
        table /= units
        inverse = np.linalg.pinv(table.T @ table, rcond=1e-12, hermitian=True)
        terms = inverse @ (table.T @ (rest * weight).ravel()) / units
        left = rest - np.tensordot(terms, np.array(columns), 1)
        widen = widening(left * weight)
        weight = 1.0 / np.sqrt(np.mean(left**2, axis=0))
    # Of the last round: its weights make the error of every row 1.
    return terms, widen * np.sqrt(np.diag(inverse)) / units


def by_figaroh(run: ArmRun) -> list[Json]:
    """Findings."""
    fit = _identified(run)
    labels, mapping = fit._params_r_for_recon, np.asarray(fit._M_matrix)
    nominal = mapping @ np.array([fit.standard_parameter[name] for name in labels])
    weighted = fit.dynamic_regressor_base * fit._wls_row_weight[:, None]
    left = (fit.tau_noised - fit.dynamic_regressor_base @ fit.phi_base) * fit._wls_row_weight
    widen = widening(left.reshape(len(run.joints), -1).T)
    covariance = widen**2 * np.linalg.inv(weighted.T @ weighted)
    off, errors = fit.phi_base - nominal, np.sqrt(np.diag(covariance))
    found, of_links = [], []
    for row, name in enumerate(fit.params_base):
        kind, _, place = name.split()[0].partition("_")
        if kind not in FIGAROH_NAMES:
            of_links.append(row)
            continue
        one = FIGAROH_NAMES[kind], place
        if sureness(run, one, off[row], errors[row]) > SURE_T:
            found.append(arm_finding(*one, off[row], 1.96 * errors[row]))
    tip = run.joints[-1]
    held = [labels.index(f"{part}_{tip}") for part in LINK if f"{part}_{tip}" in labels]
    terms, spread = _load(
        off[of_links], mapping[np.ix_(of_links, held)], covariance[np.ix_(of_links, of_links)]
    )
    if sureness(run, ("payload", run.tip), terms[0], spread[0]) > SURE_T:
        found.append(arm_finding("payload", run.tip, terms[0], 1.96 * spread[0]))
    return found


def _load(off: Array, columns: Array, covariance: Array) -> tuple[Array, Array]:
    """Generalized least squares; errors are widened by what the load leaves of `off`."""
    root = np.linalg.inv(np.linalg.cholesky(covariance))
    table, aim = root @ columns, root @ off
    inverse = np.linalg.pinv(table)
    terms = inverse @ aim
    free = max(1, len(aim) - len(terms))
    spread = max(1.0, float(np.sqrt(np.sum((aim - table @ terms) ** 2) / free)))
    return terms, spread * np.sqrt(np.sum(inverse**2, axis=1))


def _identified(run: ArmRun) -> Any:
    """FIGAROH's own identification, solved."""
    base: Any = importlib.import_module("figaroh.identification.base_identification")
    config: Any = importlib.import_module("figaroh.identification.config")
    robot: Any = importlib.import_module("figaroh.tools.robot")
    rows, count = run.rows, len(run.joints)

    class Identification(base.BaseIdentification):  # type: ignore[misc]
        """Takes signals that are smooth already."""

        def load_param(self, config_file: str, setting_type: str = "identification") -> None:
            friction = {"viscous": run.viscous.tolist(), "static": run.dry.tolist()}
            none = [0.0] * count
            stated = {
                "joints": {"active_joints": run.joints},
                "mechanics": {
                    "friction_coefficients": friction,
                    "actuator_inertias": none,
                    "joint_offsets": none,
                },
                "problem": {"wls": True},
            }
            self.identif_config = config.unified_to_legacy_identif_config(self.robot, stated)
            self.identif_config |= {name: list(range(count)) for name in ("act_idxq", "act_idxv")}

        def load_trajectory_data(self, data_source: str | None = None) -> dict[str, Array]:
            motion = {"velocities": run.v[rows], "accelerations": run.a[rows]}
            at = {"timestamps": run.step_s * rows[:, None], "positions": run.q[rows]}
            return at | motion | {"torques": run.effort[rows]}

        def process_kinematics_data(self, filter_config: Json | None = None) -> None:
            self.processed_data = dict(self.raw_data)

    logging.disable(logging.WARNING)
    with contextlib.redirect_stdout(io.StringIO()):
        fit = Identification(robot.Robot(str(run.urdf), str(run.urdf.parent)))
        fit.initialize()
        fit.solve(decimate=False, plotting=False, wls=True)
    return fit


TOOLS: dict[str, Callable[[ArmRun], list[Json]]] = {"textbook": by_textbook, "FIGAROH": by_figaroh}


def answer(tool: str, folder: Path, robot: Json) -> Json:
    """Findings in the form of the diagnosis, with seconds, of one arm."""
    for name in (
        "pinocchio",
        *(["figaroh.identification.base_identification"] * (tool == "FIGAROH")),
    ):
        importlib.import_module(name)
    begun = time.process_time()
    failure, findings = None, None
    try:
        run = arm_signals(folder / "recording.csv.gz", robot)
        if tool in TOOLS:
            findings = TOOLS[tool](run)
        else:
            from benchmarks.rivals.inverse_sysid import by_sysid_of_arms

            findings = by_sysid_of_arms(tool, run, folder)
    except (ValueError, TypeError, np.linalg.LinAlgError) as error:
        failure = str(error)
    seconds = None if findings is None and failure is None else time.process_time() - begun
    return {"findings": findings, "failure": failure, "seconds": seconds, "heldout": None}
