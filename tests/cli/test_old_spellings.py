"""Old spellings of commands do what they did and name the new one; nothing else spells so."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.cli.old_spellings import OLD_SPELLINGS, as_now
from tests.rigs.commands import every_command

ROOT = Path(__file__).parents[2]
EXEMPT = {
    "deltactl/cli/old_spellings.py",
    "tests/cli/test_old_spellings.py",
    "CHANGELOG.md",  # says what was renamed
}
KINDS = ("delta", "axis", "sensor")
PROSE = ("on", "off", "record", "install", "train", "follow", "cancel", "pause", "resume")
"""Words that a sentence may have behind the program's name."""


@pytest.mark.parametrize("old", [old for old in OLD_SPELLINGS if " --" not in old])
def test_an_old_spelling_names_the_new_one_and_does_the_same(
    old: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    new = OLD_SPELLINGS[old]
    done = CliRunner().invoke(app, [*old.split(), "--help"])
    (line,) = done.stderr.splitlines()
    assert f"'deltactl {new}'" in line
    assert done.exit_code == 0, done.output
    assert done.stdout == CliRunner().invoke(app, [*new.split(), "--help"]).stdout


@pytest.mark.parametrize(
    ("typed", "now"),
    [
        ("diagnose a.csv --inspect --set t=ms", "inspect a.csv --set t=ms"),
        ("diagnose --fleet 'runs/*.csv' --robots r", "fleet 'runs/*.csv' --robots r"),
        ("diagnose --fleet=runs/*.csv --robots r", "fleet runs/*.csv --robots r"),
        ("init a.yaml --kind=range_sensor --force", "init sensor a.yaml --force"),
        ("init --kind stepper_axis a.yaml", "init axis --drive stepper a.yaml"),
        ("init a.yaml --gear-ratio 5", "init delta a.yaml --gear-ratio 5"),
        ("version --json", "--version --json"),
        ("demo --conceal home_offset", "demo --hide home_offset"),
    ],
)
def test_options_of_an_old_spelling_are_kept(
    typed: str, now: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert as_now(shlex.split(typed), KINDS) == shlex.split(now)
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize(
    "typed",
    ["diagnose a.csv --robot r.yaml", "init axis a.yaml", "init --help", "power on", "--version"],
)
def test_a_present_spelling_is_left_alone(typed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert as_now(typed.split(), KINDS) == typed.split()
    assert not capsys.readouterr().err


def _patterns() -> list[str]:
    """What an old spelling looks like in a text, and in the words of a call in a test."""
    commands = [old for old in OLD_SPELLINGS if " " not in old]
    plain = [word for word in commands if word not in PROSE]
    quoted = [word for word in commands if word in PROSE]
    alone = [word for word, _ in every_command()]
    assert not set(commands) & set(alone)
    either = "|".join(commands)
    return [
        r"diagnose\b[^`'\"\n]* --(inspect|fleet)\b",
        r"\"--(inspect|fleet)\"",
        r"--kind (delta|servo_axis|stepper_axis|range_sensor)\b",
        r"\"--kind\", \"(delta|servo_axis|stepper_axis|range_sensor)\"",
        r"deltactl init (?!delta\b|axis\b|sensor\b)[^\s`]*\.ya?ml",
        rf"deltactl ({'|'.join(plain)})(?![\w.-])",
        rf"deltactl ({'|'.join(quoted)})(?=[`'\";,)]| --| [\w/-]+\.(ya?ml|mcap|csv))",
        rf"(deltactl\(|app, \[|cli\.main\", )\"({either})\"",
    ]


@pytest.mark.parametrize("pattern", _patterns())
def test_no_text_uses_an_old_spelling(pattern: str) -> None:
    listed = subprocess.run(
        ["git", "grep", "-nIP", "-e", pattern, "--", "."],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert listed.returncode in (0, 1), listed.stderr
    left = [line for line in listed.stdout.splitlines() if line.split(":")[0] not in EXEMPT]
    assert left == []
    assert any(re.search(pattern, line) for line in AS_BEFORE)


AS_BEFORE = (
    "type: deltactl diagnose a.csv --inspect",
    'deltactl("diagnose", "a.csv", "--inspect")',
    "deltactl init a.yaml --kind servo_axis",
    '("init", "a.yaml", "--kind", "servo_axis")',
    "see `deltactl web-user`; 'deltactl pause'",
    'deltactl("pause")',
)
"""Each pattern finds one of them, so that none is there which cannot fail."""
