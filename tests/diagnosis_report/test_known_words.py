"""What an answer reports of the effects that its robot file has from earlier diagnoses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from deltactl.diagnosis.answer.assembly import known_of
from deltactl.diagnosis.answer.records import Known
from deltactl.diagnosis.report.limits import known_line
from deltactl.models.robot import EffectEntry, FoundBy, ServoAxis


def _late(motor: int, probability: float | None = 0.98, here: bool = False) -> Known:
    return Known(
        effect="following_lag",
        component=f"motor{motor}",
        probability=probability,
        from_these_recordings=here,
    )


def test_nothing_is_said_of_a_file_without_any(make: Any) -> None:
    assert known_line(make("nothing_missing")) == ""


def test_places_of_one_effect_are_named_together(make: Any) -> None:
    said = known_line(make("explained", known=[_late(1), _late(2)]))
    assert said == (
        "Taken as known, from the robot file: drives of motors 1 and 2 that follow late."
    )


def test_the_same_recording_proves_nothing_and_another_may(make: Any) -> None:
    said = known_line(make("explained", known=[_late(1, here=True)]))
    assert "late (found in the same recording, so that its fit here proves nothing)." in said
    both = known_line(make("explained", known=[_late(1, here=True), _late(2)]))
    assert both.count("proves nothing") == 1
    assert "motor 1 that follows late (found in the same" in both


def test_what_was_not_certain_stays_so(make: Any) -> None:
    said = known_line(make("nothing_missing", known=[_late(1), _late(3, 0.55)]))
    assert said.endswith("a drive of motor 3 that follows late (55 % sure when it was found).")


def test_effects_written_by_hand_are_the_machine_itself() -> None:
    found = FoundBy(recordings=("a.csv",), on="2026-01-31", probability=0.9)
    entries = [
        EffectEntry(effect="coulomb_friction", component="axis", found=found),
        EffectEntry(effect="home_offset", component="axis"),
    ]
    axis = ServoAxis(kind="servo_axis", name="x", motion="rotary", effects=tuple(entries))
    known = known_of(axis, [Path("runs/a.csv"), Path("b.csv")])
    assert [(one.effect, one.from_these_recordings) for one in known] == [
        ("coulomb_friction", True)
    ]
    assert not known_of(axis, [Path("b.csv")])[0].from_these_recordings
