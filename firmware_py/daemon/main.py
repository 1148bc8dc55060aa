"""The daemon: builds the controller, serves it, proves that it lives, and ends it safely."""

from __future__ import annotations

import logging
import os
import sys
import time
from contextlib import closing
from pathlib import Path

from deltactl.firmware_py.controller.contract import OwnedController
from deltactl.firmware_py.controller.states import ENGAGED, State
from deltactl.firmware_py.daemon.address import daemon_socket
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.log_lines import set_up_logging
from deltactl.firmware_py.daemon.notify import Notifier, Watchdog, check_period_s
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.daemon.signals import EndSignals
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.writing.retention import RecordingKeeper

SETTLE_S = 5.0
"""How long a job may take to decelerate when the daemon is asked to end."""
SETTLE_LOOK_S = 0.1
SWITCH_S = 0.001
"""How long one thread may keep the interpreter from the control loop (Python's own: 5 ms)."""
ENGAGED_WORDS = frozenset(state.value for state in ENGAGED)
LATCHED = (State.STOPPED.value, State.FAULT.value)

_log = logging.getLogger(__name__)


def serve(
    robot: Path,
    socket: Path | None,
    simulated: bool,
    recordings: Path,
    as_built: Path | None = None,
) -> int:
    """Run the daemon until SIGTERM or SIGINT; returns its exit status.

    as_built: what the simulated robot is really like, in a file apart.

    Raises ServiceError when the socket is taken, and what `build_controller` raises.
    """
    from deltactl.firmware_py.controller.build import build_controller
    from deltactl.firmware_py.planning.prepared import Readers
    from deltactl.firmware_py.planning.process import PlanningProcess

    set_up_logging()
    sys.setswitchinterval(SWITCH_S)
    notifier = Notifier.from_environment()
    with EndSignals() as signals, closing(notifier):
        try:
            # The socket first: whoever has it has the robot too.
            listener = Listener(daemon_socket(socket))
            planning = PlanningProcess(sent=_jobs_folder(recordings))
            try:
                controller = build_controller(
                    robot,
                    simulated=simulated,
                    realtime=True,
                    recordings=recordings,
                    readers=Readers(planning.prepare, planning.read_robot),
                    as_built=as_built,
                )
            except BaseException:
                planning.close()
                listener.close()
                raise
        except DeltactlError as error:
            notifier.status(str(error))
            raise

        def note(text: str) -> None:
            controller.journal.event(controller.clock.now_ns(), "request", text)

        server = Server(controller, listener, _jobs_folder(recordings), recordings, note)
        keeper = RecordingKeeper(recordings, controller.robot.recordings)
        keeper.start()
        with closing(keeper), closing(planning):
            return run_daemon(controller, server, notifier, signals)


def run_daemon(
    controller: OwnedController, server: Server, notifier: Notifier, signals: EndSignals
) -> int:
    """Serve until a signal comes or the server dies; closes server and controller."""
    try:
        with server:
            watchdog = Watchdog(
                controller.progress_count, notifier.alive, serving=lambda: server.alive
            )
            notifier.ready()
            _log.info("listening at %s", server.path)
            latched = ""
            while not signals.count and server.alive and not controller.fatal():
                notifier.status(_in_words(controller))
                latched = _log_what_latched(controller, latched)
                signals.wait(check_period_s(notifier.watchdog_s))
                watchdog.check()
            if why := controller.fatal():
                _log.error("%s; the daemon ends, so that it is started again", why)
            notifier.stopping()
            server.end_commands()
            _settle(controller, watchdog, signals)
            return 0 if signals.count else 1
    finally:
        controller.close()


def _log_what_latched(controller: OwnedController, before: str) -> str:
    """A stop or fault, once; what is latched now, empty where nothing is."""
    status = controller.status()
    if status.state not in LATCHED:
        return ""
    now = f"{status.state}: {status.why}"
    if now != before:
        _log.warning("%s", now)
    return now


def _settle(controller: OwnedController, watchdog: Watchdog, signals: EndSignals) -> None:
    """Decelerate on the path, so that the drives lose no step; a second signal hurries."""
    if controller.status().state not in ENGAGED_WORDS:
        return
    _log.info("decelerating before the end")
    try:
        controller.cancel()
    except DeltactlError as error:
        _log.info("not cancelled: %s", error)
    give_up_s = time.monotonic() + SETTLE_S
    asked = signals.count
    while controller.status().state in ENGAGED_WORDS and signals.count == asked:
        if time.monotonic() > give_up_s:
            _log.warning("the job does not end in %g s; stopping it", SETTLE_S)
            break
        signals.wait(SETTLE_LOOK_S)
        watchdog.check()


def _in_words(controller: OwnedController) -> str:
    status = controller.status()
    job = f", job {status.job} {status.progress:.0%}" if status.job else ""
    why = f" ({status.why})" if status.why else ""
    return f"{status.robot}{' (simulated)' if status.simulated else ''}: {status.state}{why}{job}"


def _jobs_folder(recordings: Path) -> Path:
    """Where sent jobs are kept: the unit's state directory, or beside the recordings."""
    state = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
    return (Path(state) if state else recordings.absolute()) / "jobs"
