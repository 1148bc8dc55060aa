"""The planner's own process: reads one job, writes its plan into shared memory, and ends.
Or it reads one robot file.

`python -P -m deltactl.firmware_py.planning.worker DESCRIPTOR`: asked by one line of JSON on
standard input, answers by one on standard output. It
runs at a lower priority and within bounds of its own, so that nothing anybody submits can hold up
the robot.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import signal
import sys
from pathlib import Path
from typing import Any

MEMORY_BYTES = 3 * 2**30
NICE = 10


def main(arguments: list[str]) -> int:
    """One job, then the end; nothing is asked when the daemon has gone."""
    os.nice(NICE)
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.planning.packed import pack
    from deltactl.firmware_py.planning.prepared import InForce, prepare_here
    from deltactl.firmware_py.robot_file import RobotFile
    from deltactl.firmware_py.wire_errors import as_message
    from deltactl.foundation.errors import ConfigError, DeltactlError
    from deltactl.foundation.strict_yaml import Document

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    line = sys.stdin.readline()
    if not line:
        return 0
    asked = json.loads(line)
    if "robot" in asked:
        return _read_robot(asked)
    resource.setrlimit(resource.RLIMIT_CPU, (asked["most_s"], asked["most_s"] + 1))
    try:
        path = Path(asked["robot_path"])
        document = Document(path, asked["robot_text"])
        started = Path(asked["robot_started"]) if asked["robot_started"] else None
        robot = InForce(document.check(RobotFile), path, document.text, started)
        access = FileAccess(follow=False, quote=asked["quote"], most_bytes=asked["most_bytes"])
        prepared = prepare_here(Path(asked["job"]), robot, access)
        content = pack(prepared)
    except DeltactlError as error:
        return _say(as_message(error) | {"message": str(error)})
    except MemoryError:
        text = f"{asked['job']}: needs more than {MEMORY_BYTES // 2**30} GB; split it"
        return _say({"kind": ConfigError.__name__, "message": text})
    descriptor = int(arguments[0])
    os.ftruncate(descriptor, len(content))
    os.pwrite(descriptor, content, 0)
    return _say({"bytes": len(content)})


def _read_robot(asked: dict[str, Any]) -> int:
    """A robot file in place of a job; the kernel ends it when its time is over (SIGALRM)."""
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.planning.robot_read import read_robot_here
    from deltactl.firmware_py.wire_errors import as_message
    from deltactl.foundation.errors import DeltactlError

    signal.setitimer(signal.ITIMER_REAL, asked["most_s"])
    gc.disable()
    access = FileAccess(asked["follow"], asked["quote"], asked["most_bytes"])
    try:
        return _say(read_robot_here(Path(asked["robot"]), access).message())
    except DeltactlError as error:
        return _say(as_message(error) | {"message": str(error)})


def _say(answer: dict[str, Any]) -> int:
    print(json.dumps(answer), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
