"""Whatever others named: nothing of it moves a cursor, forges a line, or reads backwards."""

from __future__ import annotations

import io
import logging
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.table import Table

from deltactl.cli.main import one_line
from deltactl.cli.output import PlainConsole
from deltactl.firmware_py.daemon.log_lines import _write_out
from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.plain_file import read_plain
from deltactl.foundation.printable import file_size, is_printable, plain, printable
from deltactl.foundation.strict_yaml import Document

EVIL = ("\x1b]0;owned\x07", "a\x9bb", "\u202egnp.exe", "a\u2028b", "\x00", "\x7f", "\ud800")


@pytest.mark.parametrize("text", EVIL)
def test_what_cannot_be_seen_is_written_out(text: str) -> None:
    assert is_printable(printable(text))
    assert not is_printable(text)
    assert "\\" in printable(text)


@given(st.text())
def test_whatever_comes_it_can_be_printed_and_what_could_be_stays(text: str) -> None:
    shown = printable(text, layout=True)
    assert is_printable(shown, layout=True)
    assert printable(shown, layout=True) == shown
    assert (shown == text) == is_printable(text, layout=True)
    assert "\n" not in printable(text)


@pytest.mark.parametrize("text", EVIL[:-1])
def test_a_terminal_gets_no_sequence_from_a_name(text: str) -> None:
    out = io.StringIO()
    console = PlainConsole(file=out, force_terminal=True, highlight=False, markup=False)
    table = Table(title=text)
    table.add_column(text)
    table.add_row(f"name {text}", style="bold")
    console.print(table)
    console.print(f"recording: {text}", soft_wrap=True)
    said = out.getvalue()
    assert "\x1b[1m" in said  # our own
    for part in ("\x1b]", "\x9b", "\u202e", "\u2028", "\x00", "\x7f", "\x07"):
        assert part not in said


def test_an_error_is_one_printable_line() -> None:
    assert one_line(ConfigError("a\x1b[2Jb\nc\u202ed")) == "a\\x1b[2Jb c\\u202ed"


def test_a_log_has_one_line_an_entry() -> None:
    record = logging.LogRecord("x", 20, "x", 1, "run %s", ("a\nINFO forged\x1b[2J",), None)
    assert _write_out(record)
    assert record.getMessage() == "run a\\nINFO forged\\x1b[2J"


@pytest.mark.parametrize("value", ['"\\e[31m"', '"\\u202e"', '"a\\0b"', '"\\x9b"'])
def test_a_file_may_not_hold_what_cannot_be_seen(tmp_path: Path, value: str) -> None:
    path = tmp_path / "job.yaml"
    path.write_text(f"name: {value}\n")
    with pytest.raises(ConfigError, match=r"job.yaml:1: .*cannot be seen") as error:
        Document.read(path)
    assert str(error.value).isprintable()
    path.write_text('name: "two\\nlines"\n')
    assert Document.read(path).data == {"name": "two\nlines"}


def test_links_are_followed_only_where_that_is_asked_for(tmp_path: Path) -> None:
    real = tmp_path / "real"
    real.mkdir()
    (real / "secret").write_bytes(b"secret")
    (tmp_path / "file").symlink_to(real / "secret")
    (tmp_path / "folder").symlink_to(real)
    for name in ("file", "folder/secret"):
        assert read_plain(tmp_path / name, 100) == b"secret"
        with pytest.raises(MissingFile, match="is reached through a link; name the file itself"):
            read_plain(tmp_path / name, 100, follow=False)
    assert read_plain(real / "secret", 100, follow=False) == b"secret"


@pytest.mark.parametrize(
    ("value", "text"),
    [(-5.55112e-14, "0"), (-0.0, "0"), (1e-7, "0"), (-0.25, "-0.25"), (449.9999999999, "450")],
)
def test_what_a_subtraction_leaves_is_nothing(value: float, text: str) -> None:
    assert plain(value) == text


@pytest.mark.parametrize("size_bytes", [1, 10, 812, 3400, 48_000, 1_200_000, 7_000_000_000])
def test_no_file_has_no_size(size_bytes: int) -> None:
    number, _ = file_size(size_bytes).replace("one", "1").split()
    assert float(number) > 0.0


def test_sizes_of_files_are_in_the_unit_that_people_use() -> None:
    assert [file_size(size) for size in (0, 812, 3400, 48_000, 1_200_000)] == [
        "0 bytes", "812 bytes", "3.4 kB", "48 kB", "1.2 MB",
    ]  # fmt: skip
