"""Which files are mutated, how often, and by which tests a mutant has to be noticed."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """Files of a folder, so many mutants of each, and the tests of that folder, quickest first."""

    folder: str
    files: dict[str, int]
    tests: tuple[str, ...]


STEPS = Row(
    "drivers/steps",
    {
        "player.py": 18,
        "output.py": 15,
        "board.py": 4,
        "codes.py": 4,
        "lgpio_lines.py": 6,
        "task_host.py": 4,
        "build.py": 4,
    },
    (
        "tests/steps/test_player_properties.py",
        "tests/steps/test_lgpio_inputs.py",
        "tests/steps/test_first_reason.py",
        "tests/steps/test_step_contract.py",
        "tests/steps/test_step_backends.py",
    ),
)
RANGING = Row(
    "drivers/ranging",
    {
        "sample_reader.py": 10,
        "gating.py": 7,
        "slot.py": 8,
        "bank.py": 8,
        "sample_times.py": 8,
        "timing.py": 6,
        "vl53l1x.py": 6,
        "bus_watch.py": 6,
        "sample.py": 4,
    },
    (
        "tests/ranging/test_vl53l1x_driver.py",
        "tests/ranging/test_range_gating.py",
        "tests/ranging/test_sample_times.py",
        "tests/ranging/test_vl53l1x_tables.py",
        "tests/ranging/test_ranging_faults.py",
        "tests/ranging/test_ranging_start.py",
        "tests/ranging/test_ranging_times.py",
        "tests/ranging/test_ranging_lost.py",
        "tests/ranging/test_ranging_contract.py",
    ),
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
    (
        "tests/planner/test_step_gate.py",
        "tests/planner/test_timing_together.py",
        "tests/planner/test_path_limits.py",
        "tests/planner/test_warped_motion.py",
        "tests/planner/test_timing_moves.py",
        "tests/planner/test_motion_stream.py",
        "tests/planner/test_timing_accelerated.py",
        "tests/planner/test_approach.py",
    ),
)
CONTROLLER = Row(
    "firmware_py/controller",
    {
        "sight.py": 6,
        "home_check.py": 6,
        "homing.py": 7,
        "determined.py": 4,
        "feeder.py": 6,
        "step_watch.py": 8,
        "controller.py": 15,
        "active_job.py": 6,
        "job_queue.py": 3,
        "ranging_loop.py": 3,
    },
    (
        "tests/controller/test_feeder.py",
        "tests/controller/test_blindness.py",
        "tests/controller/test_stops_in_between.py",
        "tests/controller/test_controller_states.py",
        "tests/controller/test_controller_homing.py",
        "tests/controller/test_step_watch.py",
        "tests/controller/test_arms_at_rest.py",
        "tests/controller/test_controller_jobs.py",
    ),
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
    (
        "tests/daemon/test_security_promises.py",
        "tests/daemon/test_daemon_requests.py",
        "tests/daemon/test_daemon_life.py",
        "tests/daemon/test_daemon_abuse.py",
    ),
)
RECORDING = Row(
    "recording",
    {
        "append_file.py": 6,
        "disk.py": 6,
        "retention.py": 4,
        "names.py": 3,
        "edges.py": 6,
        "scan.py": 7,
        "writer.py": 7,
        "container.py": 6,
        "mcap_chunk.py": 3,
    },
    (
        "tests/recording/test_recorder.py",
        "tests/recording/test_disk_is_told.py",
        "tests/recording/test_retention.py",
        "tests/recording/test_recording_edges.py",
        "tests/recording/test_recordings_kept.py",
        "tests/recording/test_recording_cut.py",
        "tests/recording/test_recording_bombs.py",
    ),
)
ASSESSMENT = Row(
    "diagnosis/assessment",
    {
        "holdout.py": 10,
        "regression_holdout.py": 10,
        "covariance.py": 12,
        "significance.py": 5,
    },
    (
        "tests/axes/test_axis_held_out.py",
        "tests/diagnosis/test_held_out.py",
    ),
)
DETECTION = Row(
    "diagnosis/answer",
    {"verdict.py": 10, "assembly.py": 8, "consistency.py": 12},
    ("tests/diagnosis_answer/test_no_contradictions.py",),
)
ADMISSION = Row(
    "diagnosis/admission",
    {"excerpt.py": 10, "step_counts.py": 6},
    ("tests/diagnosis/test_bounded.py",),
)
TABLE: tuple[Row, ...] = (
    *(STEPS, RANGING, PLANNER, CONTROLLER, DAEMON, RECORDING),
    *(ASSESSMENT, DETECTION, ADMISSION),
)
