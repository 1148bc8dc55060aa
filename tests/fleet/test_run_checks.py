"""What the service announces after runs, and what it does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.proofs.warm_up import year
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.fleet.checks import RunChecks, read_announced, shown, standing
from deltactl.foundation.one_screen import laid_out
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder

PLAY = {"effect": "gear_backlash", "component": "motor2", "parameter": "width", "unit": "rad",
        "value": 0.0035, "probability": 0.97}  # fmt: skip


def runs(*found: object) -> list[dict]:
    """Rows of runs an hour apart; each `found` is a list of findings."""
    return [
        {"recording": f"r{k}", "robot": "r", "time_s": 3600.0 * k, "verdict": "x", "findings": some}
        for k, some in enumerate(found)
    ]


def test_play_is_announced_with_the_second_run_that_has_it_and_since_the_first() -> None:
    assert standing(runs([], [], [PLAY])) == []
    (one,) = standing(runs([], [], [PLAY], [PLAY]))
    assert (one.effect, one.component, one.since_s) == ("gear_backlash", "motor2", 7200.0)
    assert one.probability == 0.97
    assert standing(runs([], [PLAY], [PLAY], [])) != []
    assert standing(runs([], [PLAY], [PLAY], [], [])) == []


def test_one_run_that_misses_it_delays_nothing_two_do() -> None:
    """Near the detection limit a run misses one time in three what is there."""
    (one,) = standing(runs([], [PLAY], [], [PLAY]))
    assert one.since_s == 3600.0
    assert standing(runs([], [PLAY], [], [], [PLAY])) == []
    assert standing(runs([PLAY], [], [PLAY], [], [])) == []


OFFSET = PLAY | {"effect": "sensor_offset", "component": "range_x", "parameter": "offset",
                 "unit": "m", "value": 0.004}  # fmt: skip
COLD = OFFSET | {"value": -0.004}
SCALE = OFFSET | {"effect": "sensor_scale", "parameter": "scale", "unit": "", "value": 1.01}
SMALL = SCALE | {"value": 0.99}


def test_what_comes_with_the_warmth_of_a_day_is_not_announced_and_what_stays_is() -> None:
    """Runs an hour apart; a loose sensor is there at night, too."""
    noon, night = [[OFFSET]] * 10, [[]] * 14
    assert standing(runs(*(noon + night) * 5)) == []
    assert standing(runs(*[[OFFSET]] * 10)) == []
    (one,) = standing(runs(*night, *[[OFFSET]] * 30))
    assert (one.effect, one.since_s) == ("sensor_offset", 14 * 3600.0)


def test_what_swings_about_the_robot_file_is_not_announced() -> None:
    """Seen day and night, with opposite signs: the robot file is that of a mean temperature."""
    for warm, cold in ((OFFSET, COLD), (SCALE, SMALL)):
        assert standing(runs(*([[warm]] * 12 + [[cold]] * 12) * 5)) == []


def test_what_comes_by_chance_in_one_run_of_fifty_is_not_announced_in_200() -> None:
    """Alarms of single runs, each at another place, stay without a second run that has them."""
    rng = np.random.default_rng(4)
    rows = []
    for _ in range(200):
        effect = str(rng.choice(["gear_ratio", "home_offset", "contact"]))
        other = PLAY | {"component": f"motor{rng.integers(1, 4)}", "effect": effect}
        rows.append([other] if rng.random() < 0.02 else [])
    assert sum(map(len, rows)) >= 2
    assert standing(runs(*rows)) == []
    assert standing(runs(*[[PLAY | {"probability": 0.3}]] * 5)) == []


def test_the_service_checks_each_run_once_and_leaves_out_short_ones(tmp_path: Path) -> None:
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
    for name, seconds in (("a", 12), ("b", 12), ("short", 1)):
        its = RunConfiguration(text, "", "zhao-2023", name)
        with RunRecorder(tmp_path / f"{name}.mcap", its) as recorder:
            recorder.event(int(seconds * 1e9), "path_end", "")
    (tmp_path / "torn.mcap").write_bytes(b"\x89MCAP0\r\n")
    asked = []

    def diagnose(recording: str, robot: str) -> dict:
        asked.append(Path(recording).name)
        assert "zhao-2023" in Path(robot).read_text()
        return {"verdict": "explained", "findings": [PLAY]}

    checks = RunChecks(tmp_path, diagnose)
    rows = checks.look()
    assert sorted(asked) == ["a.mcap", "b.mcap"]
    assert len(rows) == 4
    assert checks.look() == []
    (one,) = read_announced(tmp_path)
    assert one.component == "motor2"
    checks.close()
    assert read_announced(tmp_path / "elsewhere") == []


def test_many_runs_are_shown_on_one_screen_the_newest_first() -> None:
    rows = runs(*[[PLAY]] * 60)
    rows[0] |= {"error": "r0: " + "a torn file; " * 30}
    rows[-1] |= {"says": "The model error is explained by backlash."}
    lines = laid_out(shown(rows, standing(rows)), 80, 25)
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 80
    text = " ".join(lines)
    assert "backlash in the gear or coupling of motor 2 (0.201 degrees)" in text
    assert "97 % sure" in text
    assert text.index("r59: The model error is explained by backlash.") < text.index("r58: ")
    assert "earlier runs" in lines[-1]


@pytest.mark.parametrize("number", [0, *(pytest.param(n, marks=pytest.mark.study) for n in (1, 2))])
def test_a_robot_year_with_warm_days_announces_its_play_and_hardly_anything_else(
    number: int,
) -> None:
    """`python -m benchmarks.proofs.warm_up` counts a hundred."""
    lived = year(number)
    assert lived.false <= 1
    assert lived.play_at <= 1.2


def test_a_sensor_that_was_knocked_is_announced_though_it_drifts_each_day() -> None:
    """At work by day only; a third of the offset comes and goes with the warmth."""
    hours = np.arange(8, 17)
    rows = []
    for day in range(6):
        for hour in hours:
            warm = 0.001 * (hour - 8) / 8.0
            offset = warm + (0.003 if day >= 3 else 0.0)
            some = [OFFSET | {"value": offset}] if offset > 0.0008 else []
            rows.append({"recording": f"{day}-{hour}", "robot": "r", "verdict": "x",
                         "time_s": 86400.0 * day + 3600.0 * hour, "findings": some})  # fmt: skip
    assert standing(rows[: 3 * len(hours)]) == []
    (one,) = standing(rows)
    assert one.since_s >= 2 * 86400.0
