"""Pictures of the page for docs/page: a simulated robot, in Debian's Chromium without a window.

python -m benchmarks.page_pictures docs/page after [Robot Jobs Recordings Console Plots]
"""

from __future__ import annotations

import base64
import io
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from PIL import Image

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from tests.web.conftest import CIRCLE, Browser, a_chromium, end_page, patient_robot, start_page

SIZES = {"desktop": (1280, 800, False), "phone": (390, 844, True)}
LOOKS = ("light", "dark")
SETTLE_S = 4.0
PATIENCE_S = 120.0
LIVE = "document.querySelector('.plots-card .plots')?.scrollIntoView({block: 'center'})"
COLOURS = 255
"""Colours of a picture's palette: small files that still look right."""


def show_job(browser: Browser, _: Client) -> None:
    """A checked job with its preview."""
    browser.press("check")
    browser.says("verdict", "may run", PATIENCE_S)


def show_playback(browser: Browser, _: Client) -> None:
    """The run, a third of the way."""
    browser.press("play-it")
    browser.find("play", PATIENCE_S).click()
    time.sleep(8.0)
    browser.find("play").click()


def stay(_: Browser, __: Client) -> None:
    """The tab as it opens, once the drawing is there."""
    time.sleep(SETTLE_S)


def show_plots(browser: Browser, client: Client) -> None:
    """Live plots below the drawing, while a job runs."""
    job = CIRCLE.format(name="circle", robot="zhao-2023.yaml", turns=60)
    client.submit_text(job, "circle.yaml")
    browser.says("state", "running", PATIENCE_S)
    browser.find("plots").click()
    time.sleep(4.0 * SETTLE_S)


SHOWN: dict[str, tuple[str, Callable[[Browser, Client], None]]] = {
    "Robot": ("Robot", stay),
    "Jobs": ("Jobs", show_job),
    "Recordings": ("Recordings", show_playback),
    "Console": ("Console", stay),
    "Plots": ("Robot", show_plots),
}
"""What is shown, on which tab, and what is done before."""


def turn(browser: Browser, look: str, width: int, height: int, mobile: bool) -> None:
    """Have the browser report this size and preference."""
    send = browser.driver.execute_cdp_cmd
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
    send("Emulation.setDeviceMetricsOverride", size)
    send("Emulation.setScrollbarsHidden", {"hidden": True})
    scheme = {"name": "prefers-color-scheme", "value": look}
    send("Emulation.setEmulatedMedia", {"features": [scheme]})


def save(browser: Browser, path: Path) -> None:
    """What the browser shows, as a PNG with a palette."""
    shot = browser.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
    picture = Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")
    # The means move the palette to colours of few pixels too: the amber ball stays amber.
    few = picture.quantize(COLOURS, kmeans=8, dither=Image.Dither.NONE)
    few.save(path, optimize=True)


def take(browser: Browser, folder: Path, name: str) -> None:
    """One picture in each size and look, which the file's name says."""
    for look in LOOKS:
        for size, shape in SIZES.items():
            turn(browser, look, *shape)
            time.sleep(SETTLE_S)
            browser.driver.execute_script(LIVE)
            save(browser, folder / name.format(size, look))


def main(folder: Path, name: str, *shown: str) -> None:
    """Write every picture whose name ends in `name` into the folder; of all, or of some."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as made:
        work = Path(made)
        place = work / "d.sock"
        robot = str(patient_robot(work))
        page = start_page(work, "--simulate", "--robot", robot, "--socket", str(place))
        browser = Browser(a_chromium(drawn=True))
        try:
            with Client(place) as client:
                client.power_on()
                client.home()
                heart = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
                number = client.submit_text(heart, "heart.yaml")
                while client.result(number) is None:
                    time.sleep(0.5)
                browser.driver.get(page.url)
                browser.says("state", "ready", PATIENCE_S)
                for what in shown or SHOWN:
                    tab, prepare = SHOWN[what]
                    turn(browser, LOOKS[0], *SIZES["desktop"])
                    browser.tab(tab)
                    prepare(browser, client)
                    take(browser, folder, f"{what.lower()}-{{}}-{{}}-{name}.png")
        finally:
            browser.driver.quit()
            end_page(page)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
