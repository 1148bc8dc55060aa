"""Long sentences in a window of 80 characters."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.text import Text

from deltactl.cli.output import wrapped

WORD = st.text(st.characters(codec="ascii", categories=("L", "N", "P")), min_size=1, max_size=12)


def lines(text: str, width: int = 40) -> list[str]:
    return [one.plain for one in wrapped(Text.from_markup(text), width)]


@pytest.mark.parametrize(
    ("text", "begins", "goes_on"),
    [
        ("   It shows in position, in motion and after reversals.", "   It", "   "),
        ("- Free the bearings of the axis: look for what rubs, clean.", "- Free", "  "),
        ("[bold]12. Friction holds the axis back between its directions.[/bold]", "12. F", "    "),
        ("The remaining error is consistent with measurement noise.", "The", ""),
    ],
)
def test_what_is_broken_goes_on_under_its_beginning(text: str, begins: str, goes_on: str) -> None:
    first, second = lines(text)
    assert first.startswith(begins)
    assert second.startswith(goes_on)
    assert not second.removeprefix(goes_on).startswith(" ")


def test_a_number_stays_with_its_unit() -> None:
    assert lines("the play is in all, between both 45 % sure", 36)[1] == "45 % sure"
    assert lines("the fit worsens by so much and so 1\u00a0774 more", 36)[1] == "1 774 more"


def test_bold_stays_bold_and_what_fits_is_left_alone() -> None:
    made = wrapped(Text.from_markup("[bold]1. A title that is too long for one line[/bold]"), 30)
    assert len(made) == 2
    assert all(any("bold" in str(span.style) for span in one.spans) for one in made)
    assert lines("") == [""]
    assert lines("short") == ["short"]


@given(st.lists(WORD, min_size=1, max_size=40), st.sampled_from(["", "- ", "   ", "3. "]))
def test_no_word_is_lost_and_no_line_too_long(words: list[str], lead: str) -> None:
    text = lead + " ".join(words)
    made = [one.plain for one in wrapped(Text(text), 60)]
    assert " ".join(made).split() == text.split()
    assert all(len(one) <= 60 for one in made)
