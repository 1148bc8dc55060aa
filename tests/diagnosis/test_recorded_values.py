"""Well-formed recordings with absurd times, counts and readings: an answer or one line."""

from __future__ import annotations

import sys
import tracemalloc
from random import Random

import numpy as np
import pytest

from benchmarks.endurance.fuzz_values import ROBOT, ROUNDS, Recordings
from deltactl.cli.main import main
from deltactl.foundation.errors import RecordingError
from deltactl.recording.reading.reader import read_run

TIME, ALL = 255, bytes([0, 255])
EDGES, READINGS = 2, (4, 5, 6)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Recordings:
    return Recordings(tmp_path_factory.mktemp("values"))


def times(way: int, *topics: int) -> bytes:
    """All times of these topics in another way."""
    return b"".join(bytes([TIME, topic, way]) + ALL for topic in topics)


def refusal(recordings: Recordings, data: bytes) -> str:
    """One line, or nothing where it is taken."""
    said = ""
    try:
        recordings.admit(data)
    except RecordingError as error:
        said = str(error)
    assert "\n" not in said
    assert len(said) < 500
    return said


def test_the_sound_one_is_taken(recordings: Recordings) -> None:
    assert refusal(recordings, b"") == ""
    assert len(recordings.read(b"")) == ROUNDS - 1


@pytest.mark.parametrize(
    ("way", "topics", "says"),
    [
        (0, READINGS, "no times apart"),  # all the same
        (5, READINGS, "more than a year from the start"),
        (8, READINGS, "more than a year from the start"),  # backward from 2**63 - 1
        (9, READINGS, "more than a year from the start"),  # from -2**63
        (8, (EDGES,), "more than a year from the start"),
        (9, (EDGES,), "more than a year from the start"),
        (10, (EDGES,), "more than a year from the start"),
        (3, READINGS, "no times apart"),  # whole seconds
        (4, READINGS, "samples are 20 s apart; t must be in seconds"),
    ],
)
def test_absurd_times_are_refused_in_one_line(
    recordings: Recordings, way: int, topics: tuple[int, ...], says: str
) -> None:
    assert says in refusal(recordings, times(way, *topics))


@pytest.mark.parametrize("way", [2, 6, 7])
def test_a_run_that_began_at_another_time_is_the_same_run(recordings: Recordings, way: int) -> None:
    """Also before zero, after three days, and after a year all but a few seconds."""
    moved = recordings.read(times(way, EDGES, *READINGS))
    sound = recordings.read(b"")
    for name in (*(f"steps_{motor}" for motor in (1, 2, 3)), *(f"range_{axis}" for axis in "xyz")):
        assert np.array_equal(moved.columns[name], sound.columns[name], equal_nan=True)


def test_any_values_in_a_whole_recording(recordings: Recordings) -> None:
    chance, refused = Random(20), 0
    for _ in range(12):
        changes = (chance.randbytes(4) + bytes([chance.choice((0, 9, 255))]) for _ in range(2))
        refused += bool(refusal(recordings, b"".join(changes)))
    assert 0 < refused < 12


def test_one_long_word_does_not_make_a_thousand_long(recordings: Recordings) -> None:
    """Numpy gives every text of an array the room of the longest."""
    fields = sorted(next(one for topic, one in recordings.changed(b"") if topic == "/reading/x"))
    long = bytes([fields.index("gate"), READINGS[0], 24, 0, 0])  # "good" * 999, in one message
    path = recordings.write(long)
    tracemalloc.start()
    run = read_run(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert run.readings["x"].good.sum() == ROUNDS - 2
    assert run.readings["x"].gate.nbytes < 200 * ROUNDS
    assert peak < 2_000_000


@pytest.mark.parametrize("way", [0, 8])
def test_the_command_says_it_in_one_line_with_status_2(
    recordings: Recordings,
    way: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = recordings.write(times(way, *READINGS))
    words = ["deltactl", "diagnose", str(path), "--robot", str(ROBOT)]
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"deltactl: {path}: ")


def test_a_reading_beyond_all_bounds_is_no_warning(recordings: Recordings) -> None:
    fields = sorted(next(one for topic, one in recordings.changed(b"") if topic == "/reading/x"))
    for value in (16, 17, 21):  # 1e300, -1e300, infinity
        far = bytes([fields.index("distance_m"), READINGS[0], value, 100, 9])
        assert refusal(recordings, far) == ""
