"""Errors across the socket: the same class, the same text, and what is wrong with a point."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.firmware_py.wire_errors import KINDS, as_exception, as_message
from deltactl.foundation.errors import (
    DeltactlError,
    LimitExceeded,
    MotionError,
    NotReady,
    Refusal,
    ServiceError,
    UnreachablePoint,
)

WORDS = st.text(st.characters(codec="ascii", categories=("L", "N")), min_size=1)


def over_the_socket(error: BaseException) -> DeltactlError:
    """What a client raises of it."""
    return as_exception(json.loads(json.dumps(as_message(error))))


@given(st.sampled_from([LimitExceeded, UnreachablePoint]), WORDS, WORDS, WORDS, st.booleans())
def test_what_is_wrong_with_a_point_arrives_whole(
    kind: type[MotionError], where: str, why: str, remedy: str, on_the_way: bool
) -> None:
    sent = kind.at(f"{where}: ", Refusal(why, remedy, on_the_way))
    arrived = over_the_socket(sent)
    assert type(arrived) is kind
    assert str(arrived) == f"{where}: {why}; {remedy}"
    assert isinstance(arrived, MotionError)
    assert arrived.at_point == sent.at_point


@pytest.mark.parametrize("name", sorted(KINDS))
def test_each_class_arrives_as_itself(name: str) -> None:
    arrived = over_the_socket(KINDS[name]("why not"))
    assert type(arrived) is KINDS[name]
    assert str(arrived) == "why not"


@pytest.mark.parametrize(
    "sent", [None, 3, "why", {}, {"why": "far"}, {"why": 1, "remedy": "", "on_the_way": False}]
)
def test_a_point_that_cannot_be_read_leaves_the_message(sent: object) -> None:
    arrived = as_exception({"kind": "LimitExceeded", "message": "too far", "at_point": sent})
    assert isinstance(arrived, LimitExceeded)
    assert str(arrived) == "too far"
    assert arrived.at_point is None


def test_errors_of_others_are_the_daemons_own() -> None:
    assert isinstance(over_the_socket(ZeroDivisionError("0 / 0")), ServiceError)


def test_other_words_keep_what_an_error_carries() -> None:
    first = UnreachablePoint.at("heart: point 3: ", Refusal("too far"))
    assert first.worded("too far away").at_point == first.at_point
    assert type(NotReady("a").worded("b")) is NotReady
