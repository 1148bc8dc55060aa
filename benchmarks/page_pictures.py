"""Pictures of the page for docs/page: a simulated robot, in Debian's Chromium without a window.

python -m benchmarks.page_pictures docs/page after
"""

from __future__ import annotations

import base64
import io
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from PIL import Image

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from tests.web.conftest import Browser, a_chromium, end_page, patient_robot, start_page

SIZES = {"desktop": (1280, 800, False), "phone": (390, 844, True)}
LOOKS = ("light", "dark")
TABS = ("Robot", "Jobs", "Recordings", "Console")
COLOURS = 128
"""Of a picture's palette: small files that still look right."""


def turn(browser: Browser, look: str, width: int, height: int, mobile: bool) -> None:
    """Have the browser report this size and preference."""
    send = browser.driver.execute_cdp_cmd
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
    send("Emulation.setDeviceMetricsOverride", size)
    scheme = {"name": "prefers-color-scheme", "value": look}
    send("Emulation.setEmulatedMedia", {"features": [scheme]})


def save(browser: Browser, path: Path) -> None:
    """What the browser shows, as a PNG with a palette."""
    shot = browser.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
    picture = Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def main(folder: Path, name: str) -> None:
    """Write every picture whose name ends in `name` into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as made:
        work = Path(made)
        place = work / "d.sock"
        robot = str(patient_robot(work))
        page = start_page(work, "--simulate", "--robot", robot, "--socket", str(place))
        browser = Browser(a_chromium(drawn=True))
        try:
            browser.driver.get(page.url)
            with Client(place) as client:
                client.power_on()
                client.home()
                heart = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
                client.submit_text(heart, "heart.yaml")
                wait_for(client, 0.0)
                client.submit_text(heart.replace("name: heart", "name: heart-again"), "again.yaml")
                browser.says("job", "heart")
                for look in LOOKS:
                    for size, (width, height, mobile) in SIZES.items():
                        turn(browser, look, width, height, mobile)
                        browser.driver.get(page.url)
                        browser.says("next", "")
                        for tab in TABS:
                            with suppress(Exception):
                                browser.tab(tab)
                                time.sleep(3.0)
                                save(browser, folder / f"{tab.lower()}-{size}-{look}-{name}.png")
        finally:
            browser.driver.quit()
            end_page(page)


def wait_for(client: Client, least_s: float) -> None:
    """Until no job runs."""
    time.sleep(2.0 + least_s)
    while client.status().job is not None:
        time.sleep(0.5)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
