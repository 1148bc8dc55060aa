"""Which files are mutated, how often, and by which tests a mutant has to be noticed."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """Files of a folder, so many mutants of each, and the tests of that folder."""

    folder: str
    files: dict[str, int]
    tests: tuple[str, ...]


STEPS = Row(
    "drivers/steps",
    {
        "player.py": 18,
        "output.py": 19,
        "board.py": 4,
        "lgpio_lines.py": 6,
        "hosts.py": 4,
        "build.py": 4,
    },
    ("tests/steps",),
)
RANGING = Row(
    "drivers/ranging",
    {
        "sample_reader.py": 17,
        "slot.py": 8,
        "bank.py": 14,
        "sample_times.py": 8,
        "registers.py": 6,
        "vl53l1x.py": 10,
    },
    ("tests/ranging",),
)
PLANNER = Row(
    "firmware_py/planner",
    {
        "limits.py": 13,
        "time_scaling.py": 8,
        "step_gate.py": 6,
        "stream.py": 6,
        "timing_together.py": 6,
        "timing_moves.py": 6,
        "targets.py": 4,
    },
    ("tests/planner",),
)
CONTROLLER = Row(
    "firmware_py/controller",
    {
        "sensing/sight.py": 6,
        "sensing/home_check.py": 6,
        "homing.py": 7,
        "sensing/determined.py": 4,
        "jobs/feeder.py": 6,
        "sensing/step_watch.py": 8,
        "controller.py": 15,
        "jobs/active_job.py": 6,
        "jobs/job_queue.py": 3,
        "sensing/ranging_loop.py": 3,
    },
    ("tests/controller",),
)
DAEMON = Row(
    "firmware_py/daemon",
    {
        "limits.py": 6,
        "protocol.py": 7,
        "address.py": 4,
        "actions.py": 4,
        "job_store.py": 4,
        "watchdog.py": 3,
        "command_worker.py": 4,
        "connection.py": 6,
    },
    ("tests/daemon",),
)
RECORDING = Row(
    "deltactl/recording",
    {
        "writing/append_file.py": 6,
        "writing/disk.py": 6,
        "writing/retention.py": 4,
        "writing/names.py": 3,
        "format/edges.py": 6,
        "reading/scan.py": 7,
        "writing/writer.py": 7,
        "writing/container.py": 6,
        "writing/mcap_chunk.py": 3,
    },
    ("tests/recording",),
)
ASSESSMENT = Row(
    "deltactl/diagnosis/assessment",
    {
        "holdout.py": 10,
        "regression_holdout.py": 10,
        "covariance.py": 12,
        "significance.py": 5,
    },
    (
        "tests/axes/test_axis_held_out.py",
        "tests/diagnosis/test_held_out.py",
        "tests/diagnosis/test_interval_ends.py",
        "tests/diagnosis/test_counted_tests.py",
        "tests/diagnosis/test_impossible.py",
    ),
)
DETECTION = Row(
    "deltactl/diagnosis/answer",
    {"verdict.py": 10, "assembly.py": 8, "consistency.py": 12},
    ("tests/diagnosis_answer/test_no_contradictions.py",),
)
ADMISSION = Row(
    "deltactl/diagnosis/admission",
    {"excerpt.py": 10, "step_counts.py": 6},
    ("tests/diagnosis/test_bounded.py",),
)
MENDED = (
    Row("deltactl/diagnosis/evidence", {}, ("tests/diagnosis/test_counted_tests.py",)),
    Row("deltactl/diagnosis/report", {}, ("tests/diagnosis_report",)),
    Row("models/robot.py", {}, ("tests/axes/test_axis_without_drive.py",)),
)
"""Only for known mistakes: no file of them is mutated by rule."""
TABLE: tuple[Row, ...] = (
    *(STEPS, RANGING, PLANNER, CONTROLLER, DAEMON, RECORDING),
    *(ASSESSMENT, DETECTION, ADMISSION, *MENDED),
)
