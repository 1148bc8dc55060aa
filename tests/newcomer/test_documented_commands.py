"""Every command of README and docs exists: subcommands, options, make targets, modules, files."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from tests.newcomer.test_with_a_readers_files import TYPED
from tests.newcomer.untyped import WHY
from tests.rigs.commands import found, whole_group
from tests.rigs.documented import PAGES, ROOT, Documented, fenced, inline

COMMANDS = [one for page in PAGES for one in (*fenced(page), *inline(page))]
CALLS = [one for one in COMMANDS if one.words[0] == "deltactl"]
MAKES = [one for one in COMMANDS if one.words[0] == "make"]
PYTHONS = [one for one in COMMANDS if one.words[0] in ("python", "python3")]
PLAIN = {"deltactl", "make", "python", "python3", "pytest", "git", "cd", "source", "bash"}
ON_A_PI = {
    "usermod",
    "reboot",
    "systemctl",
    "journalctl",
    "apt",
    "install",
    "umask",
    "cp",
    "nano",
    "pipx",
    "pip",
    "echo",
}
PLACEHOLDER = re.compile(r"\b[A-Z]{2,}\b|\.\.\.|\[")
"""Something of the reader's, in a sentence."""

MISSING: dict[str, tuple[str, ...]] = {
    "deltactl network train --recipe ours": ("--out", "x.tflite"),
    "deltactl network train --robot mine.yaml": ("--out", "x.tflite"),
    "deltactl export --truth": ("run.mcap", "run.csv"),
    "deltactl status sensors --calibrate": ("z=0.412",),
    "deltactl fleet": ("runs/*.mcap", "--robots", "robots"),
}
"""What a sentence leaves out of a command, for it speaks of one option."""


def test_there_are_commands_and_all_are_known() -> None:
    assert len(CALLS) > 30
    unknown = [str(one) for one in COMMANDS if one.words[0] not in PLAIN | ON_A_PI]
    assert not unknown


def test_every_command_is_typed_or_in_the_list_of_those_that_are_not() -> None:
    blocks = {one.text for one in COMMANDS if one.why not in ("", "inline")}
    # What a block on a clean clone types needs no other.
    blocks -= {one.text for one in COMMANDS if not one.why}
    assert blocks - TYPED - set(WHY) == set(), "type them (see untyped.py), or say why not"
    assert TYPED & set(WHY) == set()
    assert (TYPED | set(WHY)) - {one.text for one in COMMANDS} == set(), "no longer in the docs"


@pytest.mark.parametrize("one", CALLS, ids=str)
def test_deltactl_takes_it(one: Documented) -> None:
    """Parsed as it stands; words in capitals and dots stand for something of the reader's."""
    name, *arguments = one.words[1:]
    if name.startswith("-"):
        whole_group().make_context("deltactl", [name], resilient_parsing=True)
        return
    try:
        command, arguments = found(one.words[1:])
    except KeyError:
        pytest.fail(f"{one}: no such command")
    known = {option for each in command.params for option in (*each.opts, *each.secondary_opts)}
    options = [word.split("=")[0] for word in arguments if re.match(r"--?[a-z]", word)]
    assert {word for word in options if word not in known} <= {"--help"}, str(one)
    if hasattr(command, "commands") and not getattr(command, "invoke_without_command", False):
        assert one.why == "inline", f"{one}: a group, and none of its commands"
        return
    if one.why != "inline" or (arguments and not PLACEHOLDER.search(one.text)):
        command.make_context(name, [*arguments, *MISSING.get(one.text, ())])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    """To a file that is there, and to a heading in it. Links to other hosts are not fetched."""
    links = re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", page.read_text(encoding="utf-8"))
    own = [(page.parent / file if file else page, place) for file, place in links
           if not file.startswith("http")]  # fmt: skip
    assert not [file for file, _ in own if not file.exists()]
    assert not [(file, place) for file, place in own if place and place not in headings(file)]


def headings(page: Path) -> set[str]:
    """What a link names the headings of a page by, as GitHub and the site do."""
    lines = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", line.lower()).strip().replace(" ", "-") for line in lines}


@pytest.mark.study
def test_the_whole_jobs_on_the_page_of_jobs_may_run(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "jobs.md").read_text(encoding="utf-8")
    whole = re.findall(r"```yaml\n(name: .*?)```", text, re.DOTALL)
    assert whole
    for job in whole:
        (tmp_path / "job.yaml").write_text(job, encoding="utf-8")
        done = CliRunner().invoke(app, ["check", str(tmp_path / "job.yaml")])
        assert "may run" in done.output, done.exception


@pytest.mark.parametrize("one", MAKES, ids=str)
def test_make_has_it(one: Documented) -> None:
    dry = subprocess.run(
        ["make", "-n", *one.words[1:]],
        cwd=ROOT, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHON": sys.executable},
    )  # fmt: skip
    assert dry.returncode == 0, dry.stderr


@pytest.mark.parametrize("one", PYTHONS, ids=str)
def test_python_finds_it(one: Documented) -> None:
    words = one.words[1:]
    if words[0] != "-m":
        assert (ROOT / words[0]).is_file(), str(one)
        return
    module = words[1].replace(".", "/")
    files = (f"{module}.py", f"{module}/__main__.py")
    assert module in ("pytest", "venv") or any((ROOT / file).is_file() for file in files), str(one)
