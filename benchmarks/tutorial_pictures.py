"""Pictures of what the tutorials end with: their commands are typed, and the results drawn.

python -m benchmarks.tutorial_pictures docs/tutorials
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.page_pictures import SETTLE_S, save, turn
from deltactl.charts.figures import LineChart
from deltactl.charts.page import page
from deltactl.charts.spec import Colour, Series
from deltactl.firmware_py.run_report.tracking import robot_of, track
from deltactl.recording.reading.reader import read_run
from tests.rigs.documented import ROOT, blocks
from tests.web.conftest import Browser, a_chromium

LOOK = ("light", 1000, 640, False)
MAGNIFIED = 5


def type_all(tutorial: Path, folder: Path) -> None:
    """Run the blocks of a tutorial in a folder that has the shipped robots, up to its undoing."""
    shutil.copytree(ROOT / "config", folder / "config")
    call = f'deltactl() {{ "{sys.executable}" -P -m deltactl.cli.main "$@"; }}\n'
    for language, text in blocks(tutorial, "sh", "python"):
        if "--undo" in text:
            return
        words = ["bash", "-ec", call + text] if language == "sh" else [sys.executable, "-c", text]
        subprocess.run(words, cwd=folder, check=True, env={**os.environ, "PYTHONPATH": str(ROOT)})


def heart(folder: Path) -> None:
    """Before and after healing, from above; how far they are off is drawn larger."""
    curves = []
    for kind, colour in (("before", Colour.BAD), ("after", Colour.FIRST)):
        run = read_run(next(folder.glob(f"heal-*/{kind}-*.mcap")))
        truth = track(run, robot_of(run)).truth
        assert truth is not None
        target_m = truth.position_m - truth.error_m
        drawn_mm = 1e3 * (target_m + MAGNIFIED * truth.error_m)
        curves.append(Series(kind, drawn_mm[:, 0], drawn_mm[:, 1], colour))
    asked_mm = 1e3 * target_m
    curves.append(Series("target", asked_mm[:, 0], asked_mm[:, 1], Colour.ASKED, dashed=True))
    note = f"From above; how far the platform was off is drawn {MAGNIFIED} times as large."
    chart = LineChart("The heart", "x [mm]", "y [mm]", curves, equal_aspect=True, note=note)
    text = page("Before and after healing", [chart.html()])
    (folder / "why.html").write_text(text, encoding="utf-8")


def as_it_is(_: Path) -> None:
    """The tutorial itself writes `why.html`."""


PICTURES: dict[str, Callable[[Path], None]] = {"heal": heart, "urdf-robot": as_it_is}
"""Tutorials, and what writes the page that is shown, `why.html`."""


def main(folder: Path) -> None:
    """Write a picture beside each tutorial."""
    browser = Browser(a_chromium(drawn=False))
    try:
        turn(browser, *LOOK)
        for name, written in PICTURES.items():
            with tempfile.TemporaryDirectory() as made:
                work = Path(made)
                type_all(ROOT / "docs" / "tutorials" / f"{name}.md", work)
                written(work)
                browser.driver.get((work / "why.html").as_uri())
                time.sleep(SETTLE_S)
                save(browser, folder / f"{name}.png")
    finally:
        browser.driver.quit()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
