"""Limits that the daemon is started with are kept where they are smaller than the planner's own."""

from __future__ import annotations

import resource
import subprocess
import sys

import pytest

PLAN = """
import resource, sys
from pathlib import Path
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planning.prepared import InForce
from deltactl.firmware_py.planning.process import PlanningProcess
from deltactl.firmware_py.robot_file import load_robot

kind, soft, hard = map(int, sys.argv[1:])
resource.setrlimit(kind, (soft, hard))
config = CONFIG_FOLDER.resolve()
file = config / "zhao-2023.yaml"
planning = PlanningProcess()
try:
    robot = InForce(load_robot(file), file, file.read_text())
    print(planning.prepare(config / "square.yaml", robot).plan.job.name)
finally:
    planning.close()
"""
MEMORY, CPU = resource.RLIMIT_AS, resource.RLIMIT_CPU
ANY, GB = resource.RLIM_INFINITY, 2**30


@pytest.mark.parametrize(
    ("kind", "soft", "hard"),
    [(MEMORY, 2 * GB, 2 * GB), (MEMORY, 2 * GB, ANY), (MEMORY, 8 * GB, ANY), (CPU, 100, 100)],
)
def test_a_job_is_planned_within_them(kind: int, soft: int, hard: int) -> None:
    _, allowed = resource.getrlimit(kind)
    if allowed != ANY and (hard == ANY or hard > allowed):
        hard = allowed
        soft = min(soft, allowed)
    words = [sys.executable, "-c", PLAN, str(kind), str(soft), str(hard)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=100, check=False)
    assert done.stdout.strip() == "square", done.stderr[-500:]
