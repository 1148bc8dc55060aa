"""What the daemon and the command line ask of a controller, and what it tells them."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

from deltactl.firmware_py.controller.claim import Claim, Owner


@dataclass(frozen=True, slots=True)
class SensorStatus:
    """The newest reading of one sensor."""

    axis: str
    distance_m: float | None
    age_s: float | None
    gate: str
    signal_mcps: float | None
    health: str


@dataclass(frozen=True, slots=True)
class Status:
    """A snapshot of the robot, as `deltactl status --json` prints it."""

    state: str
    why: str
    """Why it is stopped or faulted; empty otherwise."""
    robot: str
    simulated: bool
    time_s: float
    counts: tuple[int, int, int]
    angles_rad: tuple[float, float, float] | None
    """Commanded arm angles; None while unhomed."""
    position_m: tuple[float, float, float] | None
    job: str | None
    job_id: int | None
    progress: float
    """Part of the job done, 0 to 1."""
    seconds_left: float | None
    queued: tuple[str, ...]
    recording: str | None
    recording_error: str
    late_ns: int
    """How far the pulse schedule slipped in all."""
    sensors: tuple[SensorStatus, ...] = field(default_factory=tuple)
    blind_s: float | None = None
    """How long the sensors have not shown where the arms are; None while they do."""
    robot_file_changed: str = ""
    """That the robot file on the disk is no longer the one in force; empty while it is."""
    robot_file: str = ""
    """Name of the robot file in force, as a job for this robot may name it."""
    robot_path: str = ""
    """Where that file is."""
    outputs: dict[str, bool] = field(default_factory=dict)
    """The robot file's outputs, and which are on."""
    inputs: dict[str, bool] = field(default_factory=dict)
    """Its named inputs, and which are on."""
    queued_ids: tuple[int, ...] = ()
    """Numbers of the jobs in `queued`, by which one can be cancelled."""
    planning: tuple[str, ...] = ()
    """Jobs that are being read, checked and planned; a name may change when it is read."""
    planning_ids: tuple[int, ...] = ()
    """Their numbers, by which one can be cancelled."""
    target_m: tuple[float, float, float] | None = None
    """The newest target whose pulses are queued, at most 0.1 s ahead; None between paths."""

    def as_json(self) -> dict[str, Any]:
        """Plain types only."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class JobResult:
    """How a job ended."""

    job_id: int
    name: str
    outcome: str
    """'done', 'cancelled', 'stopped', 'fault', or 'refused': it never moved."""
    why: str
    recording: str | None
    """Its file; None for a job that never ran, or whose recording could not be begun."""
    recording_error: str = ""
    """Why the recording is not whole; empty when it is."""
    warning: str = ""
    """What the user should know though the job ran to its end."""
    slower: str = ""
    """That the speed which the job asks for was never reached, and why; empty when it was."""


@dataclass(frozen=True, slots=True)
class HomeSeen:
    """What the sensors said at home: in words, and whether somebody should look."""

    text: str
    warning: str = ""

    def says(self) -> str:
        """One line."""
        return f"{self.text}; warning: {self.warning}" if self.warning else self.text


class RobotController(Protocol):
    """Runs jobs on one robot; every method may be called from any thread.

    Refusals raise NotReady, bad jobs ConfigError or MotionError, hardware trouble HardwareError.
    """

    def power_on(self) -> None:
        """Start sensors and energise the drives: OFF -> UNHOMED."""

    def power_off(self) -> None:
        """Release the drives: -> OFF. The arms may drop."""

    def home(self, accept_unseen_deg: float = 0.0, robot: Path | None = None) -> HomeSeen:
        """Learn where the arms are; blocks until done: UNHOMED or READY -> READY.

        Returns what was seen. Sensors that leave an arm undetermined refuse, unless somebody
        has looked, and accepts that an arm could be off by so much unseen. robot: another file
        of the same machine, which is in force from now on.
        """

    def submit(self, job: Path, record: Path | None = None) -> int:
        """Check a job and queue it; returns its number. Nothing moves if the check fails."""

    def pause(self) -> None:
        """Decelerate on the path and hold."""

    def resume(self) -> None:
        """Go on from where it was paused."""

    def cancel(self, job_id: int | None = None) -> None:
        """Decelerate on the path and drop that job.

        Without a number, all that run, wait or are planned, and a homing.
        """

    def move(self, job_id: int, place: int) -> None:
        """Give a job that waits another place in the queue, 1 for the next to run.

        Raises NotReady where that job does not wait.
        """

    def stop(self, reason: str) -> None:
        """Emergency stop: latched, position no longer trusted."""

    def acknowledge(self) -> None:
        """Accept a stop or fault whose cause is gone: -> UNHOMED."""

    def status(self) -> Status:
        """A snapshot."""

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended, or None while it is planned, queued or running."""

    def progress_count(self) -> int:
        """Grows only when control loop, ranging and pulse output have all moved on (watchdog)."""

    def close(self) -> None:
        """Safe stop; gives the hardware back."""


class OwnedController(RobotController, Protocol):
    """A controller in this process, as the daemon has it.

    A claim says whose a request is; without one it is of this process, and ends with it.
    """

    def accept(self, job: Path, claim: Claim) -> None:
        """Take a job that is to be checked: its number is in the claim from now on.

        Raises NotReady.
        """

    def check(self, job: Path, record: Path | None, claim: Claim) -> None:
        """Check a job that was accepted, and queue it.

        Raises what is wrong with it, and NotReady when it was called off meanwhile.
        """

    def home(
        self,
        accept_unseen_deg: float = 0.0,
        robot: Path | None = None,
        claim: Claim | None = None,
        trial: bool = False,
    ) -> HomeSeen:
        """See RobotController. trial: that file is in force until whoever asks has gone."""

    def leave(self, owner: Owner) -> None:
        """A client has gone: whatever it asked for, and was not detached, is called off."""

    def owes(self, owner: Owner) -> bool:
        """Whether a job of this client has not ended."""

    def fatal(self) -> str:
        """Why only a new process can go on; empty while this one can."""
