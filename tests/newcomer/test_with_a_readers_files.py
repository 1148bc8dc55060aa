"""Tutorials, Python, and commands that need a file of the reader or a daemon, typed verbatim."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest
import yaml

from tests.newcomer.readers_files import FILES
from tests.rigs.documented import PAGES, ROOT, blocks, fenced

pytestmark = pytest.mark.newcomer
MY_DELTA = (
    "deltactl init delta my-delta.yaml --base-radius-mm 120 --platform-radius-mm 40"
    " --upper-arm-mm 150 --forearm-mm 320 --gear-ratio 5 --microsteps-per-rev 1600"
)
A_RUN = "deltactl run circle.yaml --simulate --record {}"
DAEMON = "deltactl service daemon my-delta.yaml --simulate"
AT_THE_END = "trap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT"
READY = "until deltactl status > status.txt 2>&1; do sleep 0.2; done"

SESSIONS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "a table of one's own": ((), (
        "source .venv/bin/activate",
        "deltactl inspect data.csv",
        "deltactl init axis data-robot.yaml --motion rotary --recorded command --zero absolute",
        'deltactl diagnose data.csv --robot data-robot.yaml --set "t=time[ms]"'
        ' --set "position=angle[deg]" --set "command=target[deg]" --report why.html',
    )),
    "a LeRobot data set": ((), (
        "deltactl inspect so100/",
        "deltactl diagnose so100/ --robot axis.yaml --set t=timestamp"
        ' --set "command=action.elbow_flex.pos[deg]"'
        ' --set "position=observation.state.elbow_flex.pos[deg]" --set segment=episode_index',
    )),
    "from other programs": ((MY_DELTA,), (
        'deltactl convert part.gcode part.yaml --robot my-delta.yaml --origin "0 0 -450"'
        " --corner 0.5",
        "deltactl convert points.csv path.yaml --robot my-delta.yaml --speed 100 --corner 1",
    )),
    "a simulated robot of one's own": ((MY_DELTA,), (
        DAEMON, "deltactl power on", "deltactl home", "deltactl jog --z -5",
        "deltactl job teach pick.csv",
    )),
    "a corrected robot": ((
        "deltactl service daemon zhao-2023.yaml --simulate", "deltactl power on",
    ), (
        "deltactl check heart.yaml --robot mine.yaml",
        "deltactl home --robot mine.yaml",
        "deltactl goto 0 0 -450",
    )),
    "a corrected robot without a daemon": ((), ("deltactl run heart.yaml --robot mine.yaml",)),
    "in Foxglove": ((A_RUN.format("recordings/heart.mcap"),), (
        "deltactl web foxglove recordings/heart.mcap -o heart-foxglove.mcap",
        "deltactl web foxglove --layout deltactl-layout.json",
    )),
    "many recordings": ((
        "mkdir -p runs/monday robots", A_RUN.format("runs/monday/circle.mcap"),
        f"cp {ROOT}/config/zhao-2023.yaml robots",
    ), (
        "deltactl fleet 'runs/**/*.mcap' --robots robots/ --out fleet/"
        " --limit gear_backlash.width=0.0087",
    )),
}  # fmt: skip
"""What is typed before, and the lines of the docs."""
PYTHON: dict[str, tuple[str, ...]] = {
    "python.md": (MY_DELTA, DAEMON, "deltactl power on", "deltactl home"),
    "recordings.md": (A_RUN.format("run.mcap"),),
}
"""What is typed before the Python of a page runs."""
TUTORIALS = [
    page for page in PAGES if page.parent.name == "tutorials" and page.stem != "raspberry-pi"
]
TYPED = {line for _, lines in SESSIONS.values() for line in lines}
TYPED |= {one.text for page in TUTORIALS for one in fenced(page)}


@pytest.mark.parametrize("name", SESSIONS)
def test_it_is_typed_as_it_stands(tmp_path: Path, name: str) -> None:
    before, lines = SESSIONS[name]
    _typed(tmp_path, (*before, *lines))


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_works_from_top_to_bottom(tmp_path: Path, page: Path) -> None:
    """In an empty folder of a clone: what it needs, it makes."""
    steps = []
    for number, (language, text) in enumerate(blocks(page, "python", "sh")):
        (tmp_path / f"step{number}.py").write_text(text)
        steps += text.splitlines() if language == "sh" else [f"python step{number}.py"]
    (tmp_path / "config").symlink_to(ROOT / "config")
    _typed(tmp_path, steps, files=())


@pytest.mark.parametrize("name", PYTHON)
def test_the_python_of_a_page_runs(tmp_path: Path, name: str) -> None:
    text = "\n".join(text for _, text in blocks(ROOT / "docs" / name, "python"))
    (tmp_path / "page.py").write_text(text)
    _typed(tmp_path, (*PYTHON[name], "python page.py"))


def test_no_page_with_python_is_left_out() -> None:
    pages = {page for page in PAGES if blocks(page, "python")}
    assert pages - set(TUTORIALS) == {ROOT / "docs" / name for name in PYTHON}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_yaml_and_json_of_a_page_can_be_read(page: Path) -> None:
    for _, text in blocks(page, "yaml", "json"):  # JSON is YAML
        yaml.safe_load(text)


def _typed(folder: Path, lines: Iterable[str], files: Iterable[str] = FILES) -> None:
    """In a shell that stops at the first failure, beside these files of the reader's."""
    (folder / ".venv").symlink_to(sys.prefix)
    for file in files:
        FILES[file](folder / file)
    done = subprocess.run(
        ["bash", "-e", "-c", "\n".join([AT_THE_END, *map(_in_a_shell, lines)])],
        cwd=folder, capture_output=True, text=True, timeout=500, check=False,
        env=os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
                          "XDG_RUNTIME_DIR": str(folder), "COLUMNS": "120"},
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr[-2000:]
    assert done.returncode == 0, (done.stdout[-2000:], done.stderr[-2000:])


def _in_a_shell(line: str) -> str:
    """The daemon has a terminal of its own."""
    return f"{line} > daemon.txt 2>&1 &\n{READY}" if _starts_a_daemon((line,)) else line


def _starts_a_daemon(lines: tuple[str, ...]) -> bool:
    return any(line.startswith("deltactl service daemon") for line in lines)
