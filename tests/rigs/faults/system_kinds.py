"""Faults of the machine around the program: disk, clocks, files, clients."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

from deltactl.foundation.errors import DeltactlError, MissingFile
from deltactl.recording.writing.append_file import AppendFile
from tests.rigs.faults.kind import Kind, Undo, nothing
from tests.rigs.faults.motion_kinds import EDGE_S, press_estop
from tests.rigs.faults.stand import ROBOT_FILE, Stand
from tests.rigs.large_requests import JOB, JOBS, MB, WRONG

POSES = 90_000
MUCH = f"""name: much
robot: {ROBOT_FILE.name}
timing: {{mode: together, t_pwm_s: 0.001}}
inverse_kinematics: {{kind: geometry}}
"""
MORE_FILES = 40
GONE_ON = "recording stopped"
SLOW_S = 2.0
FULL = rf"{GONE_ON}.*(disk is full|Invalid argument)"


def fill_disk(stand: Stand, chance: Random) -> Undo:
    """From now on the recorder writes to /dev/full: ENOSPC, and EINVAL if it syncs first."""
    return _redirect(stand, "/dev/full", os.O_RDWR)


def forbid_disk(stand: Stand, chance: Random) -> Undo:
    """From now on the recorder's descriptor may only read, as near as one comes to EROFS."""
    assert stand.run is not None
    return _redirect(stand, str(stand.run.recording), os.O_RDONLY)


def slow_disk(stand: Stand, chance: Random) -> Undo:
    """The e-stop is pressed while every sync takes two seconds, as on a worn card."""
    sync = AppendFile.sync

    def slowly(file: AppendFile) -> None:
        time.sleep(SLOW_S)
        sync(file)

    AppendFile.sync = slowly  # type: ignore[method-assign, assignment]
    release = press_estop(stand, chance)

    def undo() -> None:
        AppendFile.sync = sync  # type: ignore[method-assign]
        release()

    return undo


def jump_clock(stand: Stand, chance: Random) -> Undo:
    """The wall clock of this process jumps by up to a day, either way."""
    seconds = chance.choice((-1, 1)) * chance.uniform(1.0, 86_400.0)
    real_s, real_ns = time.time, time.time_ns
    time.time = lambda: real_s() + seconds
    time.time_ns = lambda: real_ns() + round(seconds * 1e9)

    def undo() -> None:
        time.time, time.time_ns = real_s, real_ns

    return undo


def remove_network(stand: Stand, chance: Random) -> Undo:
    """The model file vanishes; the next job must be refused, naming it."""
    stand.network.unlink()
    try:
        stand.controller.submit(stand.job)
    except MissingFile as error:
        stand.controller.journal.event(time.monotonic_ns(), "refused", str(error))
    return stand.restore_network


CONNECT = """
import os, signal, socket, sys, time
s = socket.socket(socket.AF_UNIX)
s.connect(sys.argv[1])
"""
WATCHES = CONNECT + 's.sendall(b\'{"id":1,"do":"watch","rate_hz":20}\\n\'); time.sleep(60)'
FLOODS = CONNECT + (
    "end = time.monotonic() + 0.3\n"
    "s.settimeout(0.05)\n"
    "while time.monotonic() < end:\n"
    "    try:\n"
    '        s.sendall(b\'{"id":1,"do":"status"}\\n\' * 200)\n'
    "    except OSError:\n"
    "        break\n"
)
RAVES = CONNECT + (
    "try:\n"
    "    for _ in range(50):\n"
    "        s.sendall(os.urandom(4096))\n"
    "except OSError:\n"
    "    pass\n"
)
KNOCKS = (
    CONNECT
    + "hold = [socket.socket(socket.AF_UNIX) for _ in range(100)]\n"
    + (
        "for one in hold:\n"
        "    one.settimeout(0.2)\n"
        "    try:\n"
        "        one.connect(sys.argv[1])\n"
        "    except OSError:\n"
        "        pass\n"
        "time.sleep(0.2)\n"
    )
)


def with_a_client(program: str, end: signal.Signals | None) -> Callable[[Stand, Random], Undo]:
    """A client process runs `program`; after a moment it gets the signal `end`."""

    def inject(stand: Stand, chance: Random) -> Undo:
        client = subprocess.Popen([sys.executable, "-S", "-c", program, str(stand.socket)])
        if end is not None:
            time.sleep(0.1)
            client.send_signal(end)
        return lambda: _bury(client)

    return inject


def _bury(client: subprocess.Popen[bytes]) -> None:
    client.kill()
    client.wait()


def _redirect(stand: Stand, path: str, flags: int) -> Undo:
    assert stand.run is not None
    descriptor = _descriptor_of(stand.run.recording)
    other = os.open(path, flags)
    os.dup2(other, descriptor)
    os.close(other)
    return nothing


def _descriptor_of(path: Path) -> int:
    for link in Path("/proc/self/fd").iterdir():
        try:
            if Path(os.readlink(link)) == path:
                return int(link.name)
        except OSError:
            continue
    raise FileNotFoundError(path)


def submit_much(stand: Stand, chance: Random) -> Undo:
    """Somebody submits the largest job there may be, 100 000 poses in nearly 4 MB."""
    job = stand.folder / "much.yaml"
    if not job.exists():
        poses = ",".join(f"[{30 + n % 7}.12345678, 31.{n:06d}, 32.12345678]" for n in range(POSES))
        job.write_text(MUCH + f"path: {{shape: joints, angles_deg: [{poses}]}}\n")
    said: list[str] = []

    def submit() -> None:
        try:
            stand.controller.cancel(stand.controller.submit(job))
        except DeltactlError as error:
            said.append(str(error))

    thread = threading.Thread(target=submit)
    thread.start()

    def undo() -> None:
        thread.join()
        if said:
            raise AssertionError(f"the job was refused: {said}")

    return undo


def submit_wrong(stand: Stand, chance: Random) -> Undo:
    """Somebody submits 4 MB of mistakes; which kind, chance says."""
    job = stand.folder / "wrong.yaml"
    name = chance.choice((*JOBS, *WRONG))
    wrong = {**JOBS, **WRONG}[name](4 * MB)
    job.write_text(wrong + JOB if wrong.startswith("%") else JOB + wrong)
    said: list[str] = []

    def submit() -> None:
        try:
            stand.controller.submit(job)
        except DeltactlError as error:
            said.append(str(error))

    thread = threading.Thread(target=submit)
    thread.start()

    def undo() -> None:
        thread.join()
        if not said:
            raise AssertionError(f"the job was taken: {name}")

    return undo


def stop_without_files(stand: Stand, chance: Random) -> Undo:
    """Every file descriptor of the daemon is in use, and a client connects to stop the robot."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    client, held = socket.socket(socket.AF_UNIX), list[int]()
    highest = max(int(link.name) for link in Path("/proc/self/fd").iterdir())
    resource.setrlimit(resource.RLIMIT_NOFILE, (highest + MORE_FILES, hard))
    with contextlib.suppress(OSError):
        while True:
            held.append(os.open(os.devnull, os.O_RDONLY))
    client.connect(str(stand.socket))
    client.sendall(b'{"id": 1, "do": "stop", "reason": "no files"}\n')

    def undo() -> None:
        for descriptor in held:
            os.close(descriptor)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        client.close()

    return undo


def busy_threads(stand: Stand, chance: Random) -> Undo:
    """Two threads of the daemon's interpreter do nothing but compute."""
    end_s = time.monotonic() + 0.3

    def compute() -> None:
        while time.monotonic() < end_s:
            sum(range(1000))

    threads = [threading.Thread(target=compute) for _ in range(2)]
    for thread in threads:
        thread.start()
    return threads[-1].join


SYSTEM_KINDS = (
    Kind(
        "disk full", fill_disk, within_s=2.5, culprit=FULL,
        cuts_recording=True, hold_s=1.5,
    ),
    Kind(
        "disk read-only", forbid_disk, within_s=2.5, culprit=rf"heart.*mcap.*{GONE_ON}",
        cuts_recording=True, hold_s=1.5,
    ),
    Kind(
        "e-stop, and a slow disk", slow_disk, "stopped", EDGE_S, 0.2, "^e-stop$",
        "release the button",
    ),
    Kind("wall clock jumps", jump_clock),
    Kind("model file vanishes", remove_network, culprit=r"stand.tflite", within_s=2.0),
    Kind("a job of 4 MB", submit_much),
    Kind("a wrong job of 4 MB", submit_wrong),
    Kind(
        "no file descriptors, and a stop", stop_without_files, "stopped", within_s=0.3,
        seen_s=0.3, culprit="^no files$",
    ),
    Kind("busy threads in the daemon", busy_threads),
    Kind("client kill -9", with_a_client(WATCHES, signal.SIGKILL)),
    Kind("client SIGSTOP", with_a_client(WATCHES, signal.SIGSTOP)),
    Kind("client floods", with_a_client(FLOODS, None), hold_s=0.5),
    Kind("client sends garbage", with_a_client(RAVES, None)),
    Kind("a hundred clients", with_a_client(KNOCKS, None), hold_s=0.5),
)  # fmt: skip
