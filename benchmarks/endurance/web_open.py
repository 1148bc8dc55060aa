"""A page left open: python -m benchmarks.endurance.web_open [--minutes 60].

A simulated robot draws hearts without end and a real Chromium looks at its page all the while.
Printed every few minutes: memory of the page's service, of the browser's process that draws the
page, of its JavaScript heap after garbage collection, how many elements the page has, how often
the counts on it changed, and how often the page was loaded anew. The browser runs at low priority.
A machine that keeps the robot waiting for seconds faults it; it is then set going again (counted).
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

from benchmarks.costs.web_page import WATCHED, Bench, chromium

LOW = 10
MB = 2**20
LOOK_S = 10.0
HEARTS_A_MINUTE = 2.0
SPARE_MIN = 3.0
"""The robot still draws when the last line is printed."""
COUNTED = """
const before = window.seen;
if (before) window.seen = [];
return [before ? before.length : null, document.querySelectorAll("*").length];
"""


def renderer(browser: Any) -> psutil.Process:
    """The browser's process that draws the page: of its renderers the largest."""
    driver = psutil.Process(browser.service.process.pid)
    all_ = [
        process
        for process in driver.children(recursive=True)
        if "--type=renderer" in process.cmdline()
    ]
    return max(all_, key=lambda process: process.memory_info().rss)


def lower(browser: Any) -> None:
    """Its drawing takes what the robot and others leave."""
    driver = psutil.Process(browser.service.process.pid)
    for process in (driver, *driver.children(recursive=True)):
        os.setpriority(os.PRIO_PROCESS, process.pid, LOW)


def heap_mb(browser: Any) -> float:
    """JavaScript heap in use once garbage is collected."""
    browser.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
    return float(browser.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"]) / MB


def keep_drawing(bench: Bench, hearts: int, seconds: float) -> int:
    """Let that time pass; how often the robot had to be set going again."""
    again, give_up_s = 0, time.monotonic() + seconds
    while (left_s := give_up_s - time.monotonic()) > 0.0:
        if bench.state() != "running":
            bench.run_heart(hearts)
            again += 1
        time.sleep(max(0.0, min(LOOK_S, left_s)))
    return again


def main() -> None:
    """Look, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--every", type=float, default=5.0, help="minutes between two lines")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="web-") as folder:
        bench = Bench(Path(folder))
        try:
            hearts = math.ceil(HEARTS_A_MINUTE * (given.minutes + SPARE_MIN))
            bench.run_heart(hearts)
            browser = chromium(f"http://127.0.0.1:{bench.port}")
            if browser is None:
                print("no Chromium here: apt-get install chromium chromium-driver")
                return
            time.sleep(20.0)
            lower(browser)
            browser.execute_script(WATCHED)
            service, started_s = psutil.Process(bench.page.pid), time.monotonic()
            loaded = again = 0
            print(
                "minute  service MB  browser MB  heap MB  elements  counts/s  loaded anew"
                "  set going again",
                flush=True,
            )
            while True:
                passed_min = (time.monotonic() - started_s) / 60.0
                changes, elements = browser.execute_script(COUNTED)
                if changes is None:
                    loaded += 1
                    browser.execute_script(WATCHED)
                heap = heap_mb(browser)
                held_mb = [
                    process.memory_info().rss / MB for process in (service, renderer(browser))
                ]
                rate_hz = (changes or 0) / (60.0 * given.every)
                memory = f"{held_mb[0]:12.1f}{held_mb[1]:12.1f}{heap:9.1f}{elements:10d}"
                row = f"{passed_min:6.1f}{memory}{rate_hz:10.1f}{loaded:13d}{again:17d}"
                print(row, flush=True)
                if passed_min >= given.minutes:
                    break
                pause_min = min(given.every, given.minutes - passed_min + 0.01)
                again += keep_drawing(bench, hearts, 60.0 * pause_min)
            browser.quit()
        finally:
            bench.close()


if __name__ == "__main__":
    main()
