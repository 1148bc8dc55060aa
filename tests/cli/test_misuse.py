"""What is typed wrongly gets one line and exit status 2, from the real command line."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.cli.conftest import Deltactl


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("xyzzy", "No such command 'xyzzy' (see deltactl --help)"),
        ("daignose", "No such command 'daignose'. Did you mean 'diagnose'? (see"),
        ("follw", "No such command 'follw'; did you mean 'deltactl job follow'? (see deltactl --h"),
        ("job pasue", "No such command 'pasue'. Did you mean 'pause'? (see deltactl job --help)"),
        ("init dleta", "No such command 'dleta'. Did you mean 'delta'? (see deltactl init --help)"),
        ("web --simulate user ada --file u", "--simulate: is an option of deltactl web; leave it"),
        ("diagnose a.csv", "deltactl inspect a.csv"),
        ("run", "Missing argument 'job' (see deltactl run --help)"),
        ("run heart.yaml --nope", "No such option: --nope (see deltactl run --help)"),
        ("run heart.yaml --reprot x", "No such option: --reprot; did you mean '--report'? (see"),
        ("diagnose a.csv --saparator ;", "--saparator; did you mean '--set separator=...'?"),
        ("diagnose a.csv --rate-hz 50", "--rate-hz; did you mean '--set rate_hz=...'?"),
        ("run heart.yaml --accept-unseen", "needs a value, as --accept-unseen NUMBER"),
        ("web --simulate my.yaml", "a robot file is named with --robot my.yaml (see"),
        ("goto 0 0 -450 my.yaml", "a robot file is named with --robot my.yaml (see"),
        ("diagnose x.csv --save-robot --json", "needs a value, and '--json' is another option"),
        (
            "diagnose x.csv --json",
            "Option '--json' needs a value, as --json FILE (Write the answer"
            " here as JSON, - for the terminal) (see deltactl diagnose --help)",
        ),
        ("goto 0 0 -450 --robot", "Option '--robot' needs a value, as --robot TEXT (Robot file"),
        ("demo prove --cases many --out out", "Invalid value for '--cases'"),
    ],
)
def test_one_line_says_what_was_wrong_and_where_help_is(
    deltactl: Deltactl, typed: str, said: str
) -> None:
    run = deltactl(*typed.split(), status=2)
    (line,) = run.stderr.splitlines()
    assert line.startswith("deltactl: ")
    assert said in line
    assert not run.stdout


def test_nothing_typed_is_answered_by_the_help() -> None:
    command = [sys.executable, "-m", "deltactl.cli.main"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "deltactl run heart.yaml" in run.stdout + run.stderr
    assert not run.stderr
