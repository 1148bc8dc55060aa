"""The planner's own process: reads one job, writes its plan into shared memory, and ends.

`python -P -m deltactl.firmware_py.planning.worker DESCRIPTOR`: asked by one line of JSON on
standard input, answers by one on standard output. It
runs at a lower priority and within bounds of its own, so that nothing anybody submits can hold up
the robot.
"""

from __future__ import annotations

import json
import os
import resource
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

    memory_bytes = _bounded(resource.RLIMIT_AS, MEMORY_BYTES)
    line = sys.stdin.readline()
    if not line:
        return 0
    asked = json.loads(line)
    _bounded(resource.RLIMIT_CPU, asked["most_s"], grace=1)
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
        text = f"{asked['job']}: needs more than {memory_bytes / 2**30:.2g} GB; split it"
        return _say({"kind": ConfigError.__name__, "message": text})
    descriptor = int(arguments[0])
    os.ftruncate(descriptor, len(content))
    os.pwrite(descriptor, content, 0)
    return _say({"bytes": len(content)})


def _bounded(kind: int, most: int, grace: int = 0) -> int:
    """Hold this process to `most`, or to the smaller limit that it is started with; returns it.

    grace: how much more the kernel gives before it ends the process.
    """
    soft, hard = (
        one if one != resource.RLIM_INFINITY else None for one in resource.getrlimit(kind)
    )
    least = min(one for one in (most, soft, hard) if one is not None)
    last = least + grace
    resource.setrlimit(kind, (least, last if hard is None else min(last, hard)))
    return least


def _say(answer: dict[str, Any]) -> int:
    print(json.dumps(answer), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
