"""Defects that the diagnosis once had, put back one at a time: each has a test that fails then.

    python -m benchmarks.mutation.mutants --named --folder diagnosis
    python -m benchmarks.mutation.mutants --named --folder models/robot.py

Each has a test that fails when the mistake is put back.
"""

from __future__ import annotations

from benchmarks.mutation.named_mistake import Named

MENDED: tuple[Named, ...] = (
    Named(
        "nothing missing at another level than the alarm's",
        "deltactl/diagnosis/answer/verdict.py",
        "sound = not seen(p) and is_noise(fit, rest)",
        "sound = not p <= 1e-4 and is_noise(fit, rest)",
    ),
    Named(
        "nothing missing above the noise floor",
        "deltactl/diagnosis/answer/verdict.py",
        "return not seen(rest.p) and at_floor(fit)",
        "return not seen(rest.p)",
    ),
    Named(
        "explained without a held-out gain",
        "deltactl/diagnosis/answer/verdict.py",
        "and at_floor(fit) and faint(fit, rest) and gained(findings, fit)",
        "and at_floor(fit) and faint(fit, rest)",
    ),
    Named(
        "a residual below the noise floor",
        "deltactl/diagnosis/answer/assembly.py",
        "min(fit.noise_floor_m, most)",
        "fit.noise_floor_m",
    ),
    Named(
        "shares that add up to more than one",
        "deltactl/diagnosis/answer/assembly.py",
        "    if total <= most:\n",
        "    if total >= 0.0:\n",
    ),
    Named(
        "a stiffness of 1e+300",
        "deltactl/diagnosis/answer/finding.py",
        "HUGE = 1e100",
        "HUGE = 1e301",
    ),
    Named(
        "an interval of no width",
        "deltactl/diagnosis/answer/consistency.py",
        "            if not low < high:\n",
        "            if low > high:\n",
    ),
    Named(
        "a scan that did not run, counted",
        "deltactl/diagnosis/evidence/detection.py",
        "joints = len(self._jumps(self.empty))",
        "joints = 3",
    ),
    Named(
        "detection limits without variance inflation",
        "deltactl/diagnosis/assessment/detection_limits.py",
        "scatter = float(scorer.variance_inflation[number])",
        "scatter = 1.0",
    ),
    Named(
        "detection limits at the threshold, without power",
        "deltactl/diagnosis/assessment/detection_limits.py",
        "return scatter * noncentrality(threshold / scatter, df, ASSESSMENT.power)",
        "return threshold",
    ),
    Named(
        "a latency's detection limit without the delay that is always fitted",
        "deltactl/diagnosis/assessment/detection_limits.py",
        "if size is not None and number in held:",
        "if size is None and number in held:",
    ),
    Named(
        "the held-out figure before with the findings in it",
        "deltactl/diagnosis/assessment/regression_holdout.py",
        "(frozenset[str](), before)",
        "(best.keys, before)",
    ),
    Named(
        "less than one lost step",
        "deltactl/diagnosis/assessment/impossible.py",
        "< VERDICT.least_steps)",
        "< 0.0)",
    ),
    Named(
        "a size at its bound",
        "deltactl/diagnosis/assessment/impossible.py",
        "at in (coordinate.low, coordinate.high) and at != candidate.kind.nothing",
        "at != at",
    ),
    Named(
        "a drive section where rows are angles",
        "models/robot.py",
        "drive: Drive | None = None",
        "drive: Drive",
    ),
    Named(
        "charts of an axis that slides in rad",
        "deltactl/diagnosis/report/phrases/axis_units.py",
        'linear = isinstance(robot, ServoAxis) and robot.motion == "linear"',
        "linear = False",
    ),
    Named(
        "held-out blocks that took part in the choice of causes, unsaid",
        "deltactl/diagnosis/report/phrases/fit_words.py",
        " (causes were chosen with all of it)",
        "",
    ),
    Named(
        "a torque in N",
        "deltactl/diagnosis/report/phrases/sizes.py",
        ', ("torque", "N"): "force"}',
        "}",
    ),
    Named(
        "a limit for a hung controller four times as long",
        "firmware_py/controller/control_loop.py",
        "silent_ns > ns(self.robot.steps.heartbeat_s)",
        "silent_ns > 4 * ns(self.robot.steps.heartbeat_s)",
    ),
    Named(
        "20 s of silence from the pulse process",
        "drivers/steps/hosts.py",
        "SILENCE_NS = 2_000_000_000",
        "SILENCE_NS = 20_000_000_000",
    ),
    Named(
        "a status that waits for the robot file",
        "firmware_py/controller/file_in_force.py",
        "looking.join(GLANCE_S)",
        "looking.join()",
    ),
    Named(
        "no pause without file descriptors, and a line in the log each time",
        "firmware_py/daemon/server.py",
        "if not self._without_files:",
        "if True:",
    ),
)
