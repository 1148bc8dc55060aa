"""How long somebody waits for the check of a job."""

from __future__ import annotations

import math
import threading

from deltactl.firmware_py.controller.claim import Claim
from deltactl.firmware_py.daemon.job_checks import JobCheck


def test_a_wait_without_limit_ends_with_the_check() -> None:
    check = JobCheck(Claim(), lambda: None)
    threading.Timer(0.05, check.carry_out).start()
    assert check.wait(math.inf)
    assert check.refusal is None
