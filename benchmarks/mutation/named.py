"""Mistakes that tests once let through, each in its place, and survivors that change nothing."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.mutation.mended import MENDED
from benchmarks.mutation.named_mistake import Named

NAMED: tuple[Named, ...] = (
    Named(
        "the first stop reason",
        "drivers/steps/player.py",
        "            return\n        self._state = b.STOPPED\n",
        "            pass\n        self._state = b.STOPPED\n",
    ),
    Named(
        "the first stop reason, asked for twice",
        "drivers/steps/output.py",
        "if self._board.words[b.STATE] != b.STOPPED:  # the first reason stays",
        "if True:  # the first reason stays",
    ),
    Named(
        "READY over a stop during homing",
        "firmware_py/controller/homing.py",
        "                still_wanted()\n                self._machine.output.set_counts",
        "                self._machine.output.set_counts",
    ),
    Named(
        "a queue that outlives a stop",
        "firmware_py/controller/jobs/jobs.py",
        "        self._drop(outcome, why)\n        self.held = False\n",
        "        self.held = False\n",
    ),
    Named(
        "jobs that outlive 'off'",
        "firmware_py/controller/controller.py",
        '            self._call_off(rule, "the robot was switched off")\n',
        "",
    ),
    Named(
        "jobs that outlive their client",
        "firmware_py/controller/controller.py",
        "                self.jobs.call_off(rule.ends, "
        "CLIENT_WENT, lambda one: one.owner is owner)\n",
        "",
    ),
    Named(
        "a pause that holds nothing that waits",
        "firmware_py/controller/jobs/jobs.py",
        "        self.held = True\n",
        "",
    ),
    Named(
        "outputs on after a cancel in the last moment",
        "firmware_py/controller/jobs/active_job.py",
        "        if self.phase is Phase.SETTLE:\n            self._make_safe(now_ns)\n",
        "",
    ),
    Named(
        "the feeder's hang check",
        "firmware_py/controller/jobs/feeder.py",
        "            self._check_awake(now_ns)\n",
        "",
    ),
    Named(
        "homing on one sensor",
        "firmware_py/controller/sensing/home_check.py",
        "    if determine(robot, good) or off_deg <= accepted_deg:",
        "    if good.any() or off_deg <= accepted_deg:",
    ),
    Named(
        "homing on refused readings",
        "firmware_py/controller/sensing/ranging_loop.py",
        "one is not None and one.gate is Gate.GOOD and one.t_ns >= since_ns",
        "one is not None and one.t_ns >= since_ns",
    ),
    Named(
        "homing on old readings",
        "firmware_py/controller/sensing/ranging_loop.py",
        "one is not None and one.gate is Gate.GOOD and one.t_ns >= since_ns",
        "one is not None and one.gate is Gate.GOOD",
    ),
    Named(
        "the e-stop's pull-up turned to pull-down",
        "drivers/steps/lgpio_lines.py",
        "self._gpio.SET_PULL_UP",
        "self._gpio.SET_PULL_DOWN",
    ),
    Named(
        "alarm bits unshifted without an e-stop",
        "drivers/steps/lgpio_lines.py",
        "return group[0], 0 if estop else 1",
        "return group[0], 0",
    ),
    Named(
        "singularity between points",
        "firmware_py/planner/limits.py",
        "        for row in first_true(reached.margin < limit):",
        "        for row in first_true(reached.margin < -1.0):",
    ),
    Named(
        "the box on the way in joint space",
        "firmware_py/planner/limits.py",
        "        problems += self._way_problems(lap, reached)\n",
        "",
    ),
    Named(
        "fdatasync",
        "deltactl/recording/writing/append_file.py",
        "        os.fdatasync(self._descriptor)",
        "        pass",
    ),
    Named(
        "the disk's reserve while running",
        "deltactl/recording/writing/disk.py",
        "        if self._file.free_bytes() < self._file.reserve_bytes:",
        "        if False:",
    ),
    Named(
        "the disk's reserve at the beginning",
        "deltactl/recording/writing/append_file.py",
        "if (free_bytes := self.free_bytes()) < reserve_bytes:",
        "if (free_bytes := self.free_bytes()) < 0:",
    ),
    Named(
        "two sensors at 0x29",
        "drivers/ranging/bank.py",
        "        if held and not self._somebody_addressing():",
        "        if held:",
    ),
    Named(
        "held-out blocks that leak into the fit",
        "deltactl/diagnosis/assessment/holdout.py",
        "np.where(held[white.rows], 0.0, white.weight)",
        "white.weight",
    ),
    Named(
        "held-out RMS of the trained part",
        "deltactl/diagnosis/assessment/holdout.py",
        "rms(observed - after.predicted[held], valid[held], columns)",
        "rms(fitter.observed[~held] - after.predicted[~held], valid[~held], columns)",
    ),
    Named(
        "events carried to another run",
        "deltactl/diagnosis/assessment/holdout.py",
        "[term for term in solution.terms if not term.candidate.kind.event]",
        "list(solution.terms)",
    ),
    Named(
        "held-out blocks of a lone machine that leak into the fit",
        "deltactl/diagnosis/assessment/regression_holdout.py",
        "scale = np.where(held, 0.0, noise.scale)",
        "scale = noise.scale",
    ),
    Named(
        "events of a lone machine carried to another run",
        "deltactl/diagnosis/assessment/regression_holdout.py",
        "frozenset(k for k in best.keys if k not in LASTING)",
        "best.keys",
    ),
    Named(
        "the sandwich",
        "deltactl/diagnosis/assessment/covariance.py",
        "widen = np.clip(ratio, 1.0, 3.0)",
        "widen = np.ones_like(ratio)",
    ),
    Named(
        "what no robot file can promise",
        "deltactl/diagnosis/assessment/covariance.py",
        "cov += pulled @ pulled.T + np.diag(giving_way(solution))",
        "cov += np.diag(giving_way(solution))",
    ),
    Named(
        "a stop that gives way",
        "deltactl/diagnosis/assessment/covariance.py",
        "cov += pulled @ pulled.T + np.diag(giving_way(solution))",
        "cov += pulled @ pulled.T",
    ),
    Named(
        "look-elsewhere",
        "deltactl/diagnosis/assessment/significance.py",
        "single * tests(selected)",
        "single",
    ),
    *MENDED,
)

EQUIVALENT: dict[str, str] = json.loads(
    Path(__file__).with_name("equivalent.json").read_text(encoding="utf-8")
)
"""Survivors that are no mistakes, by name, each with the reason."""
