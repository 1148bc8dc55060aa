"""Limits that the daemon is started with are kept where they are smaller than the planner's own."""

from __future__ import annotations

import json
import resource
import subprocess
import sys

import pytest

PLAN = """
import json, os, resource, sys
from pathlib import Path
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planning.prepared import InForce
from deltactl.firmware_py.planning.process import PlanningProcess
from deltactl.firmware_py.robot_file import load_robot

def planned(kind, soft, hard):
    resource.setrlimit(kind, (soft, hard))
    config = CONFIG_FOLDER.resolve()
    file = config / "zhao-2023.yaml"
    planning = PlanningProcess()
    try:
        robot = InForce(load_robot(file), file, file.read_text())
        print(planning.prepare(config / "square.yaml", robot).plan.job.name, flush=True)
    finally:
        planning.close()

for limit in json.loads(sys.argv[1]):
    child = os.fork()  # a limit cannot be raised again
    if not child:
        planned(*limit)
        os._exit(0)
    os.waitpid(child, 0)
"""
MEMORY, CPU = resource.RLIMIT_AS, resource.RLIMIT_CPU
ANY, GB = resource.RLIM_INFINITY, 2**30
SMALLER = ((MEMORY, 2 * GB, 2 * GB), (MEMORY, 2 * GB, ANY), (MEMORY, 8 * GB, ANY), (CPU, 100, 100))


@pytest.mark.study
def test_a_job_is_planned_within_them() -> None:
    limits = []
    for kind, soft, hard in SMALLER:
        _, allowed = resource.getrlimit(kind)
        if allowed != ANY and (hard == ANY or hard > allowed):
            soft, hard = min(soft, allowed), allowed
        limits.append((kind, soft, hard))
    words = [sys.executable, "-c", PLAN, json.dumps(limits)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=100, check=False)
    assert done.stdout.split() == ["square"] * len(SMALLER), done.stderr[-500:]
