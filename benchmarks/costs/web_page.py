"""The page: python -m benchmarks.costs.web_page [--seconds 20] [--pages 1].

A simulated robot draws a heart; a real Chromium (skipped where there is none) looks at its page.
Printed: how often the counts on the page change and how old they are when they do, processor time
of the page's service and of the daemon's two processes, how much of the latter went into simulated
hardware (benchmarks/simulated_share.py), how often its control loop went round (50 Hz, less
on a machine that keeps it waiting), how late its step schedule slipped (`late_ns` of its status),
and how long after STOP is pressed the last edge went out. All of it with no page, with a page that
nobody draws (a connection that listens as a browser does: what the page itself costs), and with
Chromium, which draws in software on the same cores here; on a Pi it is another machine.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
import uuid
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import socketio

from benchmarks.simulated_share import TALLY, make_tally, tally
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import ServiceError
from deltactl.models.robot import FloatArray
from deltactl.recording.reading.reader import read_run

WATCHED = """
const place = document.querySelector('[data-testid="counts"]');
window.seen = [];
new MutationObserver(() => window.seen.push([performance.timeOrigin + performance.now(),
  place.textContent])).observe(place, {childList: true, characterData: true, subtree: true});
"""
"""Notes when the counts on the page change, and to what. In the benchmark only."""
CLIENT_ID = re.compile(r'client_id["\']?\s*[:=]\s*["\']([0-9a-f-]{36})')
LOOK_S = 0.02
ROOT = Path(__file__).resolve().parents[2]
SETTLE_S = 5.0
"""The planner of the next job is started beside a job's beginning, and loads for a second."""
PROGRAMS = {"service": "benchmarks.simulated_share", "web": "deltactl.cli.main"}
LONGEST_S = 3.0


class Bench:
    """A daemon and a page over it, in processes of their own."""

    def __init__(self, folder: Path):
        self._folder = folder
        self.socket = folder / "d.sock"
        self.tally = folder / "tally"
        make_tally(self.tally)
        # Jobs bear the pauses of a machine that draws its own browser.
        text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
        robot = folder / "zhao-2023.yaml"
        robot.write_text(text.replace("backend: pulse", "heartbeat_s: 5.0\n  backend: pulse"))
        self.daemon = self._start("service", "daemon", str(robot), "--simulate")
        while not self._answers():
            assert self.daemon.poll() is None, (folder / "service.log").read_text(encoding="utf-8")
            time.sleep(0.1)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = int(probe.getsockname()[1])
        self.page = self._start("web", "--port", str(self.port))
        self._wait_for_page()

    def _answers(self) -> bool:
        """Whether the daemon is up; on a loaded machine it may take long to say so."""
        try:
            return self.socket.exists() and daemon_answers(self.socket)
        except ServiceError:
            return False

    def run_heart(self, repeats: int = 60) -> None:
        """Whatever it did, on, home, and a heart again and again; 60 take half an hour."""
        job = self._folder / "heart.yaml"
        text = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
        job.write_text(text.replace("repeats: 1", f"repeats: {repeats}"))
        with Client(self.socket) as client:
            if client.status().state in ("stopped", "fault"):
                client.acknowledge()
            if client.status().state != "off":
                client.power_off()  # drops the simulated arms onto their stops
            client.power_on()
            client.home()
            client.submit(job, detach=True)
            while client.status().state != "running":
                time.sleep(0.1)
        time.sleep(SETTLE_S)

    def state(self) -> str:
        """As the daemon says."""
        with Client(self.socket) as client:
            return str(client.status().state)

    def close(self) -> None:
        """End both."""
        for process in (self.page, self.daemon):
            process.terminate()
            process.wait(20.0)

    def _start(self, *call: str) -> subprocess.Popen[bytes]:
        more = ["--socket", str(self.socket), "--recordings", str(self._folder / "recordings")]
        there = {TALLY: str(self.tally), "PYTHONPATH": str(ROOT)}
        with (self._folder / f"{call[0]}.log").open("wb") as log:
            command = [sys.executable, "-P", "-m", PROGRAMS[call[0]], *call, *more]
            return subprocess.Popen(command, stdout=log, stderr=log, env=os.environ | there)

    def _wait_for_page(self) -> None:
        while True:
            try:
                socket.create_connection(("127.0.0.1", self.port), 1.0).close()
                return
            except OSError:
                time.sleep(0.1)


class BarePage:
    """Loads the page as a browser does and listens to its changes; keeps only when they came."""

    def __init__(self, port: int):
        place = f"http://127.0.0.1:{port}"
        with urllib.request.urlopen(f"{place}/", timeout=30.0) as answer:
            found = CLIENT_ID.search(answer.read().decode())
        assert found is not None, "the page has another form than this benchmark knows"
        self.updates_s: list[float] = []
        self._socket: Any = socketio.Client()
        self._socket.on("update", lambda *_: self.updates_s.append(time.monotonic()))
        query = f"client_id={found[1]}&tab_id={uuid.uuid4()}&document_id={uuid.uuid4()}"
        url, sockets = f"{place}?{query}&next_message_id=0&implicit_handshake=true", ["websocket"]
        self._socket.connect(url, socketio_path="/_nicegui_ws/socket.io", transports=sockets)

    def rate_hz(self) -> float:
        """Changes a second, from the first to the last."""
        times = self.updates_s
        return (len(times) - 1) / max(1e-9, times[-1] - times[0]) if len(times) > 1 else 0.0

    def close(self) -> None:
        """Close it."""
        self._socket.disconnect()


def chromium(url: str) -> Any:
    """A browser, or None."""
    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if binary is None or driver is None:
        return None
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = binary
    words = "headless=new no-sandbox disable-dev-shm-usage enable-unsafe-swiftshader"
    for word in (*words.split(), "use-angle=swiftshader"):
        options.add_argument(f"--{word}")
    browser = webdriver.Chrome(options=options, service=Service(driver))
    browser.get(url)
    return browser


def used_s(process: subprocess.Popen[bytes]) -> float:
    """Processor time of a process and its children."""
    found = psutil.Process(process.pid)
    times = [used.cpu_times() for used in (found, *found.children(recursive=True))]
    return float(sum(used.user + used.system for used in times))


def costs(bench: Bench, seconds: float) -> dict[str, float]:
    """Processor time [% of a core], rounds a second and slip over a while in which nobody asks."""
    before, started_s = _costs_so_far(bench), time.monotonic()
    time.sleep(seconds)
    passed_s = time.monotonic() - started_s
    after = _costs_so_far(bench)
    return {name: (after[name] - before[name]) / passed_s for name in before} | {
        "slip_ms": after["slip_ms"] - before["slip_ms"]
    }


def _costs_so_far(bench: Bench) -> dict[str, float]:
    with Client(bench.socket) as client:
        slip_ms = client.status().late_ns / 1e6
    simulated_s, rounds = tally(bench.tally)
    return {
        "page": 100.0 * used_s(bench.page),
        "daemon": 100.0 * used_s(bench.daemon),
        "simulated": 100.0 * simulated_s,
        "rounds": float(rounds),
        "slip_ms": slip_ms,
    }


def counts_had(bench: Bench, seconds: float) -> list[tuple[float, str]]:
    """The counts as the daemon had them, by epoch [s]; to ask so often costs it some percent."""
    had: list[tuple[float, str]] = []
    with Client(bench.socket) as client:
        give_up_s = time.monotonic() + seconds
        while time.monotonic() < give_up_s:
            counts = "  ".join(str(count) for count in client.status().counts)
            if not had or had[-1][1] != counts:
                had.append((time.time(), counts))
            time.sleep(LOOK_S)
    return had


def lags_s(had: list[tuple[float, str]], seen: list[list[Any]]) -> FloatArray:
    """Age of each value when the page showed it, to about 20 ms: the daemon's nearest counts."""
    at_s = np.array([when for when, _ in had])
    counts = np.array([[int(part) for part in text.split()] for _, text in had])
    found = []
    for when_ms, text in seen:
        shown_s = when_ms / 1e3
        near = (at_s > shown_s - LONGEST_S) & (at_s < shown_s)
        if near.any() and shown_s < at_s[-1]:
            away = np.abs(counts[near] - [int(part) for part in text.split()]).sum(axis=1)
            found.append(shown_s - float(at_s[near][int(np.argmin(away))]))
    return np.array(found)


def stopped_after_ms(bench: Bench, browser: Any) -> float:
    """Press the stop button of the page; until the last edge that went out, as recorded."""
    with Client(bench.socket) as client:
        recording = client.status().recording
        button = browser.find_element("css selector", '[data-testid="stop"]')
        pressed_s = time.time()
        button.click()
        while client.status().state == "running":
            time.sleep(0.01)
    assert recording is not None
    time.sleep(1.0)
    run = read_run(Path(recording))
    last_s = (run.configuration.start_epoch_ns + int(run.edges.t_ns[-1])) / 1e9
    return 1e3 * (last_s - pressed_s)


def _tell(what: str, found: dict[str, float]) -> None:
    used = f"page {found['page']:5.1f} %  daemon {found['daemon']:5.1f} % of a core"
    share = (
        f"{found['simulated']:.1f} of it simulated hardware; {found['rounds']:.0f} rounds a second"
    )
    slip = f"schedule slipped {found['slip_ms']:.2f} ms"
    print(f"{what:<16}{used} ({share}), {slip}", flush=True)


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--pages", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="web-") as folder:
        bench = Bench(Path(folder))
        try:
            bench.run_heart()
            print(f"load of this machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
            _tell("no page open", costs(bench, given.seconds))
            bare = [BarePage(bench.port) for _ in range(given.pages)]
            _tell(f"{given.pages} undrawn", costs(bench, given.seconds))
            print(f"changes sent to it: {bare[0].rate_hz():.1f} Hz")
            for page in bare:
                page.close()
            opened = [chromium(f"http://127.0.0.1:{bench.port}") for _ in range(given.pages)]
            if None in opened:
                print("no Chromium here: apt-get install chromium chromium-driver")
                return
            time.sleep(8.0)
            _tell(f"{given.pages} in Chromium", costs(bench, given.seconds))
            opened[0].execute_script(WATCHED)
            had = counts_had(bench, given.seconds)
            seen = opened[0].execute_script("return window.seen")
            lag = 1e3 * lags_s(had, seen)
            gaps = np.diff([when for when, _ in seen])
            print(f"update rate: {1e3 / gaps.mean():.1f} Hz; longest gap {gaps.max():.0f} ms")
            p50, p95, most = np.percentile(lag, [50, 95, 100])
            print(f"lag: p50 {p50:.0f} ms, p95 {p95:.0f} ms, max {most:.0f} ms ({len(lag)} values)")
            print(f"STOP pressed to the last edge: {stopped_after_ms(bench, opened[0]):.0f} ms")
            for browser in opened:
                browser.quit()
        finally:
            bench.close()


if __name__ == "__main__":
    main()
