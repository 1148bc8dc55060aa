"""Answers of the tools: their numbers are those of the JSON, and they are short."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import deltactl as dc
from deltactl.assistants.answers import MOST_TOKENS, of_diagnosis, of_next_run, tokens
from deltactl.assistants.refused import KINDS
from tests.assistants.calls import Answered, Call, all_answered, diagnose, write_slide

CALLS = (
    ("inspect", {"recording": "slide.csv"}),
    diagnose("slide.csv"),
    ("explain", {"diagnosis": "a", "finding": 1}),
    ("next_run", {"diagnosis": "a"}),
)


@pytest.fixture(scope="module")
def answers(root: Path) -> dict[str, Answered]:
    """An answer of each tool."""
    return {one.call[0]: one for one in all_answered(root, CALLS)}


@pytest.mark.parametrize("tool", [name for name, _ in CALLS])
def test_every_number_is_one_of_the_json_and_the_answer_is_short(
    answers: dict[str, Answered], tool: str
) -> None:
    answer = answers[tool]
    assert not answer.refused
    assert answer.invented == []
    assert answer.tokens <= MOST_TOKENS
    assert replace(answer, text=f"{answer.text} 1234.5").invented == ["1234.5"]


@pytest.mark.study
def test_the_finding_is_that_of_the_python_interface(
    answers: dict[str, Answered], root: Path
) -> None:
    (found,) = answers["diagnose"].structured["findings"]
    assert (found["effect"], found["component"], found["unit"]) == ("gear_ratio", "axis", "1")
    assert found["interval"][0] < found["value"] < found["interval"][1]
    assert found["value"] == pytest.approx(1.02, abs=1e-4)
    recording = dc.read(root / "slide.csv", ["t=time_s[s]", *COLUMNS])
    same = dc.diagnose(recording, dc.Robot.load(root / "slide.yaml"))
    mine = answers["diagnose"].json["findings"][0]["parameters"]["scale"]["value"]
    assert mine == pytest.approx(same.findings["size"][0], rel=1e-6)
    assert answers["explain"].structured["finding"] == found


def test_an_inspection_says_what_the_diagnosis_takes(
    answers: dict[str, Answered], root: Path
) -> None:
    seen = answers["inspect"].structured
    assert seen["kind"] == "servo_axis"
    assert "unit=UNIT" in seen["columns"]
    assert "for UNIT" in " ".join(answers["inspect"].text.split())
    asked = {
        "recordings": ["slide.csv"],
        "columns": [one.replace("UNIT", "deg") for one in seen["columns"]],
        "robot_text": seen["robot_text"],
    }
    (made,) = all_answered(root, [("diagnose", asked)])
    assert made.structured["findings"][0]["effect"] == "gear_ratio"


def long_answer(sentences: int) -> dict[str, object]:
    """An answer that says more than there is room for."""
    words = [f"Sentence {n} of many about the machine." for n in range(sentences)]
    says = dict.fromkeys(("verdict", "steps", "findings", "helps", "or_else", "remarks"), words)
    points = np.round(np.random.default_rng(0).normal(size=(300, 3)), 4).tolist()
    plan = {"job": {"points_m": points}, "minutes": 2.0, "tells_apart": ["a b"]}
    answer = {"recordings": ["r.csv"], "robot": "r", "verdict": "explained", "findings": []}
    answer |= {"probability_nothing_missing": None, "next_experiment": plan}
    return {"json": answer | {"not_testable": [], "smallest_detectable": []}, "says": says}


@pytest.mark.parametrize("sentences", [1, 40, 4000])
@pytest.mark.parametrize("worded", [of_diagnosis, of_next_run])
def test_what_is_too_long_is_left_out_and_the_answer_says_where_it_is(worded, sentences) -> None:
    text, structured = worded("a", long_answer(sentences))
    assert tokens(text) + tokens(json.dumps(structured)) <= MOST_TOKENS + 1
    assert ("deltactl://diagnoses/a" in text) is (sentences > 1 or worded is of_next_run)


def test_one_sentence_without_an_end_is_cut() -> None:
    made = long_answer(1)
    made["says"]["verdict"] = ["words " * 20_000]
    text, structured = of_diagnosis("a", made)
    assert tokens(text) + tokens(json.dumps(structured)) <= MOST_TOKENS + 1


REFUSED: tuple[tuple[Call, str, str], ...] = (
    (("inspect", {"recording": "../secret.csv"}), "path", ""),
    (("inspect", {"recording": "link.csv"}), "path", ""),
    (("inspect", {"recording": "elsewhere/secret.csv"}), "path", ""),
    (("inspect", {"recording": "../nothing.csv"}), "path", ""),
    (("inspect", {"recording": "/proc/self/environ"}), "path", ""),
    (("inspect", {"recording": "a\0b"}), "missing_file", ""),
    (("inspect", {"recording": "x" * 4000}), "missing_file", ""),
    (("inspect", {"recording": "sldie.csv"}), "missing_file", ""),
    (("inspect", {"recording": "noise.csv"}), "recording", ""),
    (("inspect", {"recording": "empty.csv"}), "recording", ""),
    (("inspect", {"recording": "torn.mcap"}), "recording", ""),
    (("inspect", {}), "arguments", "recording"),
    (("inspect", {"recording": "slide.csv", "root": "/"}), "arguments", "root"),
    (("write", {"recording": "slide.csv"}), "unknown_name", ""),
    (("diagnose", {"recordings": ["slide.csv"]}), "arguments", "robot"),
    (diagnose("slide.csv", columns=["position=seem[mm]"]), "columns", "seem"),
    (diagnose("slide.csv", columns=["position=seen[furlong]"]), "columns", "position"),
    (diagnose("slide.csv", columns=None), "columns", "t"),
    (diagnose("slide.csv", robot_text="kind: [axis"), "robot_file", ""),
    (diagnose("slide.csv", robot_text=None, robot="wrong.yaml"), "robot_file", ""),
    (diagnose("slide.csv", robot_text=None, robot="arm.yaml"), "path", ""),
    (diagnose("slide.csv", robot_text=None, robot="includes.yaml"), "path", ""),
    (diagnose("slide.csv", robot_text=None, robot="../secret.yaml"), "path", ""),
    (diagnose("short.csv"), "short", ""),
    (diagnose("still.csv"), "still", "command"),
    (("explain", {"diagnosis": "z", "finding": 1}), "unknown_name", "diagnosis"),
    (("next_run", {"diagnosis": "../a"}), "unknown_name", "diagnosis"),
)


@pytest.fixture(scope="module")
def refusals(root: Path) -> list[Answered]:
    """All of them on one connection, which none of them ends."""
    return all_answered(root, [call for call, _, _ in REFUSED])


@pytest.mark.parametrize("number", range(len(REFUSED)))
def test_a_refusal_has_its_kind_its_column_and_what_to_do(
    refusals: list[Answered], number: int
) -> None:
    made, (_, kind, column) = refusals[number], REFUSED[number]
    refusal = made.structured["refused"]
    assert made.refused
    assert (refusal["kind"], refusal["column"]) == (kind, column), made.text
    assert refusal["why"]
    assert refusal["do"]
    assert "Traceback" not in made.text
    assert "\n" not in made.text
    assert made.tokens < 400
    assert {refusal["why"], refusal["do"]} <= set(made.text.replace(". ", ": ").split(": ")) | {
        refusal["why"], refusal["do"],
    }  # fmt: skip


def test_what_lies_outside_is_refused_whether_it_is_there_or_not(refusals: list[Answered]) -> None:
    there, not_there = (refusals[n].structured["refused"] for n in (0, 3))
    assert there["why"].replace("secret", "nothing") == not_there["why"]
    assert {name for _, name in KINDS} >= {"path", "missing_file"}


@pytest.mark.study
def test_a_hundred_calls(root: Path, tmp_path: Path) -> None:
    """Machines of several kinds; prints the longest answer."""
    calls = scripted(tmp_path)
    made = all_answered(tmp_path, calls)
    made += all_answered(root, [call for call, _, _ in REFUSED])
    assert len(made) >= 100
    assert len({one.structured["verdict"] for one in made if "verdict" in one.structured}) > 1
    assert [one.call for one in made if one.invented and not one.refused] == []
    assert [one.call for one in made if one.tokens > MOST_TOKENS] == []
    assert all({"kind", "column", "why", "do"} <= one.structured["refused"].keys()
               for one in made if one.refused)  # fmt: skip
    assert "defect" not in {one.structured["refused"]["kind"] for one in made if one.refused}
    refused = sum(one.refused for one in made)
    longest = max(one.tokens for one in made)
    print(f"{len(made)} calls, {refused} refused, longest answer {longest:.0f} tokens at most")


def scripted(folder: Path) -> list[Call]:
    """Inspect, diagnose, explain and what next, for tables of slides, a sensor and a delta."""
    calls: list[Call] = []
    names = "abcdefghijklmnop"
    made = 0

    def follow(asked: Call) -> None:
        nonlocal made
        name, made = names[made], made + 1
        calls.append(asked)
        calls.extend(("explain", {"diagnosis": name, "finding": n}) for n in (1, 2, 3))
        calls.append(("next_run", {"diagnosis": name}))

    for seed, (scale, lag_s) in enumerate(
        [(1.0, 0.0), (1.01, 0.0), (1.0, 0.02), (0.98, 0.05), (1.05, 0.1), (1.3, 0.0), (-1.0, 0.0)]
    ):
        write_slide(folder / f"slide{seed}.csv", seed, scale, lag_s)
        calls.append(("inspect", {"recording": f"slide{seed}.csv"}))
        if scale > 0.0:  # a sign is refused, and takes no name
            follow(diagnose(f"slide{seed}.csv"))
        else:
            calls.append(diagnose(f"slide{seed}.csv"))
    follow(diagnose("slide1.csv", "slide2.csv", holdout=["slide0.csv"]))
    rng = np.random.default_rng(1)
    true_m = np.repeat(np.linspace(0.05, 0.4, 30), 20)
    rows = np.column_stack(
        [np.arange(600) / 50.0, true_m, 1.03 * true_m + rng.normal(0, 1e-3, 600)]
    )
    np.savetxt(folder / "sensor.csv", rows, "%.6g", ",", header="t,distance,range", comments="")
    sensor = {"recordings": ["sensor.csv"], "robot_text": "{kind: range_sensor, name: tof}"}
    calls.append(("inspect", {"recording": "sensor.csv"}))
    follow(("diagnose", sensor))
    t_s = np.arange(1500) / 50.0
    steps = np.round(2000.0 * np.sin(0.7 * t_s))
    play_rad = 0.004 * (np.gradient(steps) > 0.0)
    theta_rad = steps * 2.0 * np.pi / 16000.0 - play_rad + rng.normal(0.0, 1e-4, 1500)
    rows = np.column_stack([t_s, steps, theta_rad])
    np.savetxt(folder / "motor.csv", rows, "%.6g", ",", header="t,steps_1,theta_1", comments="")
    motor = "{kind: stepper_axis, name: m, drive: {microsteps_per_rev: 1600, gear_ratio: 10}}"
    calls.append(("inspect", {"recording": "motor.csv"}))
    follow(("diagnose", {"recordings": ["motor.csv"], "robot_text": motor}))
    for number, angle in enumerate((0.0, 0.02)):
        fault = {"effect": "home_offset", "component": "motor3", "parameters": {"angle": angle}}
        faults = [fault] if angle else []
        dc.simulate("circle.yaml", faults=faults, seed=1).save(folder / f"delta{number}.csv")
        calls.append(("inspect", {"recording": f"delta{number}.csv"}))
        follow(("diagnose", {"recordings": [f"delta{number}.csv"], "robot": "zhao-2023.yaml"}))
    calls += [("inspect", {"recording": f"slide{n}.csv", "columns": COLUMNS}) for n in range(7)]
    return calls


COLUMNS = ["command=target[mm]", "position=seen[mm]"]
