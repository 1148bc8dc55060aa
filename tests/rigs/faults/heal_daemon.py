"""A daemon on the simulated robot whose sensors and drives fail when standard input says so.

`python -m tests.rigs.faults.heal_daemon FOLDER`, with `mine.yaml` in the folder. The words are
`blind` and `see` (all three sensors), and `trip N` (a drive's alarm). It ends with its standard
input, as when who started it is killed.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from contextlib import closing
from pathlib import Path

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.main import SWITCH_S, run_daemon
from deltactl.firmware_py.daemon.notify import Notifier
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.daemon.signals import EndSignals
from deltactl.firmware_py.planning.prepared import Readers
from deltactl.firmware_py.planning.process import PlanningProcess

BLIND_RAW_STATUS = 4
"""The raw code of a sample without a usable signal (VL53L1X ULD)."""


def obey(controller: Controller) -> None:
    """Carry out the words of standard input; its end is that of the daemon."""
    rig, bench = controller.machine.rig, controller.machine.bench
    assert rig is not None
    assert bench is not None
    for line in sys.stdin:
        words = line.split()
        if words[0] == "trip":
            bench.trip(int(words[1]))
        else:
            for chip in rig.chips.values():
                chip.faults.raw_status = BLIND_RAW_STATUS if words[0] == "blind" else None
    os.kill(os.getpid(), signal.SIGTERM)


def main() -> int:
    """Serve until a signal comes."""
    folder = Path(sys.argv[1])
    sys.setswitchinterval(SWITCH_S)
    recordings = folder / "recordings"
    with EndSignals() as signals, closing(PlanningProcess()) as planning:
        listener = Listener(folder / "s")
        controller = build_controller(
            folder / "mine.yaml",
            simulated=True,
            realtime=True,
            recordings=recordings,
            readers=Readers(planning.prepare, planning.read_robot),
        )
        threading.Thread(target=obey, args=(controller,), daemon=True).start()
        server = Server(controller, listener, folder / "jobs", recordings)
        with closing(Notifier.from_environment()) as notifier:
            return run_daemon(controller, server, notifier, signals)


if __name__ == "__main__":
    sys.exit(main())
