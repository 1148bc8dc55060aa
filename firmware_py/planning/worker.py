"""The planner's own process: reads robot files and jobs, and ends once it has planned a job.

`python -P -m deltactl.firmware_py.planning.worker DESCRIPTOR`: asked by lines of JSON on standard
input, answers each by one on standard output; a plan is written into shared memory. It runs at a
lower priority and within bounds of its own, so that nothing anybody submits can hold up the robot.
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
    import deltactl.firmware_py.planning.prepared  # noqa: F401  before anything is asked

    memory_bytes = _least(resource.RLIMIT_AS, MEMORY_BYTES)
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))
    started_with_s = _least(resource.RLIMIT_CPU)
    # Trees of plain values hold no cycles, and looking for them takes half the time of a file.
    gc.disable()
    while line := sys.stdin.readline():
        asked = json.loads(line)
        if "robot" in asked:
            answer = _robot(asked)
        else:
            _limit_time(asked["most_s"], started_with_s)
            answer = _plan(asked, int(arguments[0]), memory_bytes)
        print(json.dumps(answer), flush=True)
        if "bytes" in answer:
            break
        gc.collect()
    return 0


def _least(kind: int, most: int = sys.maxsize) -> int:
    """The smallest of `most` and the limits that this process is started with."""
    limits = [one for one in resource.getrlimit(kind) if one != resource.RLIM_INFINITY]
    return min([most, *limits])


def _limit_time(most_s: int, started_with_s: int) -> None:
    """Let the kernel end this process (SIGXCPU) when the next question takes longer."""
    ends_s = math.ceil(time.process_time()) + most_s
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (min(ends_s, started_with_s), hard))


def _plan(asked: dict[str, Any], descriptor: int, memory_bytes: int) -> dict[str, Any]:
    """Plan a job; the kernel ends the process when its time is over (SIGXCPU)."""
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.planning.packed import pack
    from deltactl.firmware_py.planning.prepared import InForce, prepare_here
    from deltactl.firmware_py.robot_file import RobotFile
    from deltactl.firmware_py.wire_errors import as_message
    from deltactl.foundation.errors import ConfigError, DeltactlError
    from deltactl.foundation.strict_yaml import Document

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
        text = f"{asked['job']}: needs more than {memory_bytes / 2**30:.2g} GB; split it"
        return {"kind": ConfigError.__name__, "message": text}
    os.ftruncate(descriptor, len(content))
    os.pwrite(descriptor, content, 0)
    return {"bytes": len(content)}


def _robot(asked: dict[str, Any]) -> dict[str, Any]:
    """Read a robot file; the kernel ends the process when it has worked for too long (SIGPROF)."""
    from deltactl.firmware_py.file_access import FileAccess
    from deltactl.firmware_py.planning.prepared import read_robot_here
    from deltactl.firmware_py.wire_errors import as_message
    from deltactl.foundation.errors import DeltactlError

    signal.setitimer(signal.ITIMER_PROF, asked["most_s"])
    access = FileAccess(asked["follow"], asked["quote"], asked["most_bytes"])
    try:
        return read_robot_here(Path(asked["robot"]), access).message()
    except DeltactlError as error:
        return as_message(error) | {"message": str(error)}
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
