"""Several recordings of one robot, diagnosed together on the page."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement

from deltactl.diagnosis.admission.which_robot import carried_by
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder
from deltactl.web.behind.own_recordings import (
    CHOSEN,
    Chosen,
    OwnRecordings,
    inspected,
    mapping_text,
)
from deltactl.web.behind.shelf import Shelf
from deltactl.web.behind.worker import diagnose
from tests.web.conftest import Browser, WebPage

ZHAO = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
AXIS = "kind: servo_axis\nname: wrist\nmotion: rotary\n"


def a_run(path: Path, robot: str, name: str = "r") -> Path:
    with RunRecorder(path, RunConfiguration(robot, "name: x\n", name, "x")) as recorder:
        recorder.commanded(0, (0, 0, 0))
    return path


def a_table(path: Path, hertz: float) -> Path:
    """An axis that stands 0.01 rad off where it is sent, with the small change of a real one."""
    rows = ["t,command,position"]
    for k in range(800):
        wanted = 0.5 * math.sin(2 * math.pi * hertz * k * 0.01)
        noise = 1e-4 * math.sin(12.9898 * k * k)
        rows.append(f"{k * 0.01:.3f},{wanted:.6f},{wanted + 0.01 + noise:.6f}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


@pytest.mark.study
def test_the_worker_diagnoses_several_as_one(tmp_path: Path) -> None:
    robot_file, made = tmp_path / "axis.yaml", tmp_path / "made"
    robot_file.write_text(AXIS)
    made.mkdir()
    tables = [a_table(tmp_path / f"{name}.csv", f) for name, f in (("slow", 0.3), ("fast", 0.9))]
    assert diagnose(made, robot_file, *tables)["verdict"]
    answer = json.loads((made / "answer.json").read_text())
    assert answer["recordings"] == [str(one) for one in tables]


def test_the_columns_of_a_table_are_guessed_chosen_and_taken(tmp_path: Path) -> None:
    robot_file, made = tmp_path / "axis.yaml", tmp_path / "made"
    robot_file.write_text(AXIS)
    made.mkdir()
    plain = a_table(tmp_path / "plain.csv", 0.3).read_text().splitlines()
    rows = [line.split(",") for line in plain[1:]]
    table = tmp_path / "0a1b.csv"
    table.write_text("ms,goal,angle\n" + "".join(
        f"{1e3 * float(t):.0f},{math.degrees(float(c)):.4f},{math.degrees(float(p)):.4f}\n"
        for t, c, p in rows))  # fmt: skip
    (tmp_path / "0a1b.csv.name").write_text("wrist.csv")
    found = inspected(table)
    assert [one["name"] for one in found["columns"]] == ["t", "command", "position"]
    assert found["columns"][0]["unit"] == "ms"
    chosen = [Chosen("ms", "t", "ms"), Chosen("goal", "command", "deg"),
              Chosen("angle", "position", "deg")]  # fmt: skip
    (tmp_path / f"0a1b.csv{CHOSEN}").write_text(mapping_text(found["mapping"], chosen))
    diagnose(made, robot_file, table)
    report = (made / "report.html").read_text()
    assert "wrist.csv" in report
    assert "0a1b" not in report
    (first, *_) = json.loads((made / "answer.json").read_text())["findings"]
    assert abs(next(iter(first["parameters"].values()))["value"]) == pytest.approx(0.01, rel=0.05)


def test_runs_count_as_of_one_robot_whatever_their_files_believe_of_it(tmp_path: Path) -> None:
    plain = a_run(tmp_path / "a.mcap", ZHAO)
    corrected = a_run(tmp_path / "b.mcap", f"{ZHAO}\neffects: []\n")
    both = carried_by([plain, corrected], tmp_path / "none.yaml")
    assert both.robot_text.endswith("effects: []\n")
    other = a_run(tmp_path / "c.mcap", ZHAO.replace("name: zhao-2023", "name: sister"))
    with pytest.raises(RecordingError, match=r"two robots .*differ in name"):
        carried_by([plain, other], tmp_path / "none.yaml")


def test_several_are_listed_as_long_as_each_is_there(tmp_path: Path) -> None:
    shelf = Shelf(tmp_path, OwnRecordings(tmp_path / "own"), tmp_path / "made")
    for name in ("a", "b"):
        (tmp_path / f"{name}.mcap").write_bytes(b"")
    name = shelf.together(shelf.newest_first())
    (several,) = (one for one in shelf.newest_first() if one.parts)
    assert several.made.name == name
    assert shelf.together(list(reversed(several.parts))) == name
    (tmp_path / "b.mcap").unlink()
    assert [one.title for one in shelf.newest_first()] == ["a"]


def test_two_are_ticked_and_have_one_answer(browser: Browser, simulated: WebPage) -> None:
    both = [simulated.recordings / f"{name}.mcap" for name in ("motion-one", "motion-two")]
    for one in both:
        one.parent.mkdir(exist_ok=True)
        one.write_bytes(b"no recording")
    try:
        browser.tab("Recordings")
        for one in both:
            browser.wait(lambda one=one: tick(browser, one.stem), f"{one} is not listed")
        assert not browser.find("together").is_enabled()
        for one in both:
            tick(browser, one.stem)[0].click()
        browser.says("together", "diagnose 2 together")
        browser.press("together")
        browser.says("recording", "motion-one + motion-two")
        browser.says("failed", "motion-")
        assert str(simulated.recordings) not in browser.text("failed")
        assert not browser.find("together").is_enabled()
    finally:
        for one in both:
            one.unlink()


def tick(browser: Browser, name: str) -> list[WebElement]:
    place = f'[aria-label="choose {name}"]'
    return browser.driver.find_elements(By.CSS_SELECTOR, place)
