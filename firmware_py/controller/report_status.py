"""The status of a controller as one snapshot."""

from __future__ import annotations

from dataclasses import dataclass

from deltactl.firmware_py.controller.contract import SensorStatus, Status
from deltactl.firmware_py.controller.jobs.active_job import ActiveJob
from deltactl.firmware_py.controller.sensing.sight import Blindness
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.linkage.scalar import counted_pose

TRUSTED = frozenset({State.READY, State.PLANNING, State.RUNNING, State.PAUSED})
"""States in which the counters say where the arms are."""


@dataclass(frozen=True, slots=True)
class Running:
    """What of a controller changes while it runs."""

    state: State
    why: str
    job: ActiveJob | None
    queued: tuple[str, ...]
    sensors: tuple[SensorStatus, ...]
    recording_error: str = ""
    """Why nothing more is written of the job that runs."""
    blind: Blindness | None = None
    queued_ids: tuple[int, ...] = ()
    planned: tuple[tuple[int, str], ...] = ()
    """Numbers and names of jobs that are being planned."""
    robot_file_changed: str = ""
    robot_file: str = ""
    robot_path: str = ""


def snapshot(
    robot: RobotFile, calibrated: CalibratedInverse, machine: Machine, running: Running
) -> Status:
    """Everything a user may want to know now. robot_file: of the same robot."""
    now_ns = machine.clock.now_ns()
    output = machine.output.status()
    angles_rad, position_m = (
        counted_pose(output.counts, robot.drive.rad_per_step, calibrated.position_of_one_m)
        if running.state in TRUSTED
        else (None, None)
    )
    job = running.job
    return Status(
        state=running.state.value,
        why=running.why,
        robot=robot.name,
        simulated=machine.simulated,
        time_s=now_ns / NS_PER_S,
        counts=output.counts,
        angles_rad=angles_rad,
        position_m=position_m,
        job=job.name if job else None,
        job_id=job.number if job else None,
        progress=job.progress(now_ns) if job else 0.0,
        seconds_left=job.seconds_left(now_ns) if job else None,
        queued=running.queued,
        queued_ids=running.queued_ids,
        planning=tuple(name for _, name in running.planned),
        planning_ids=tuple(number for number, _ in running.planned),
        recording=job.recording if job else None,
        recording_error=running.recording_error,
        late_ns=output.slip_ns,
        sensors=running.sensors,
        blind_s=running.blind.seconds if running.blind else None,
        robot_file_changed=running.robot_file_changed,
        robot_file=running.robot_file,
        robot_path=running.robot_path,
        outputs=machine.switches.states(output.switched),
        inputs={name: line() for name, line in machine.inputs.items()},
        target_m=job.target_m if job else None,
    )
