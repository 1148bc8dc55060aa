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
import math
import os
import resource
import signal
import sys
import time
from pathlib import Path
from typing import Any

MEMORY_BYTES = 3 * 2**30
NICE = 10


def main(arguments: list[str]) -> int:
    """One question after another, until one has led to a plan or the daemon has gone."""
    os.nice(NICE)
    import deltactl.firmware_py.planning.packed
    import deltactl.firmware_py.planning.robot_read  # noqa: F401  before anything is asked

    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = MEMORY_BYTES if hard == resource.RLIM_INFINITY else min(MEMORY_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    # Trees of plain values hold no cycles, and looking for them takes half the time of a file.
    gc.disable()
    while line := sys.stdin.readline():
        asked = json.loads(line)
        answer = _robot(asked) if "robot" in asked else _plan(asked, int(arguments[0]))
        print(json.dumps(answer), flush=True)
        if "bytes" in answer:
            break
        gc.collect()
    return 0


def _plan(asked: dict[str, Any], descriptor: int) -> dict[str, Any]:
    """Plan a job; the kernel ends the process when its time is over (SIGXCPU)."""
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.planning.packed import pack
    from deltactl.firmware_py.planning.prepared import InForce, prepare_here
    from deltactl.firmware_py.robot_file import RobotFile
    from deltactl.firmware_py.wire_errors import as_message
    from deltactl.foundation.errors import ConfigError, DeltactlError
    from deltactl.foundation.strict_yaml import Document

    used_s = math.ceil(time.process_time())
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (used_s + asked["most_s"], most))
    try:
        path = Path(asked["robot_path"])
        document = Document(path, asked["robot_text"])
        started = Path(asked["robot_started"]) if asked["robot_started"] else None
        robot = InForce(document.check(RobotFile), path, document.text, started)
        access = FileAccess(follow=False, quote=asked["quote"], most_bytes=asked["most_bytes"])
        prepared = prepare_here(Path(asked["job"]), robot, access)
        content = pack(prepared)
    except DeltactlError as error:
        return as_message(error) | {"message": str(error)}
    except MemoryError:
        text = f"{asked['job']}: needs more than {MEMORY_BYTES // 2**30} GB; split it"
        return {"kind": ConfigError.__name__, "message": text}
    os.ftruncate(descriptor, len(content))
    os.pwrite(descriptor, content, 0)
    return {"bytes": len(content)}


def _robot(asked: dict[str, Any]) -> dict[str, Any]:
    """Read a robot file; the kernel ends the process when its time is over (SIGALRM)."""
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.planning.robot_read import read_robot_here
    from deltactl.firmware_py.wire_errors import as_message
    from deltactl.foundation.errors import DeltactlError

    signal.setitimer(signal.ITIMER_REAL, asked["most_s"])
    access = FileAccess(asked["follow"], asked["quote"], asked["most_bytes"])
    try:
        return read_robot_here(Path(asked["robot"]), access).message()
    except DeltactlError as error:
        return as_message(error) | {"message": str(error)}
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
