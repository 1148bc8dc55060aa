"""What every set of current-commanded drives does; here on the fake over a plant."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from deltactl.drivers.current_drives import CurrentDrives, Plant
from deltactl.drivers.fakes.current_drives import FakeCurrentDrives, PlannedFault
from deltactl.firmware_py.simulation.servo_world import plant_of
from deltactl.foundation.errors import DriveAlarm

PERIOD_S, COUNT_RAD, LIMIT_A = 1e-4, 1e-3, 0.5
Make = Callable[..., FakeCurrentDrives]


class Recorder:
    """A plant that notes what it is given and stands where it is put."""

    def __init__(self) -> None:
        self.currents: list[tuple[float, float, float]] = []
        self.held = 0
        self.at = (0.1, 0.2, 0.3)

    def advance(self, first: float, second: float, third: float) -> None:
        self.currents.append((first, second, third))

    def hold(self) -> None:
        self.held += 1

    def place(self, angles_rad: tuple[float, float, float]) -> None:
        self.at = angles_rad

    def angles_rad(self) -> tuple[float, float, float]:
        return self.at


@pytest.fixture
def plant() -> Recorder:
    return Recorder()


@pytest.fixture
def drives(plant: Recorder) -> Make:
    def make(**options) -> FakeCurrentDrives:
        return FakeCurrentDrives(
            plant,
            period_s=PERIOD_S,
            rad_per_count=COUNT_RAD,
            current_limit_a=LIMIT_A,
            **options,
        )

    return make


def test_the_fake_and_the_plant_keep_their_contracts(drives: Make, micro, drive) -> None:
    asked: CurrentDrives = drives()
    plant: Plant = plant_of(micro, drive, micro.masses)
    assert asked.read_counts() == (100, 200, 300)
    assert len(plant.angles_rad()) == 3


def test_counts_are_whole_and_can_be_set(drives: Make, plant: Recorder) -> None:
    made = drives()
    made.set_counts((5, 6, 7))
    assert made.read_counts() == (5, 6, 7)
    plant.place((0.1 + 2.4 * COUNT_RAD, 0.2 - 0.6 * COUNT_RAD, 0.3))
    assert made.read_counts() == (7, 5, 7)


def test_a_drive_gives_its_limit_and_no_more(drives: Make, plant: Recorder) -> None:
    made = drives()
    made.enable()
    made.set_currents_a(0.1, 9.0, -9.0)
    assert plant.currents == [(0.1, LIMIT_A, -LIMIT_A)]
    with pytest.raises(ValueError, match="must be a number"):
        made.set_currents_a(float("nan"), 0.0, 0.0)


@pytest.mark.parametrize("brakes", [True, False])
def test_drives_that_are_off_give_no_current(drives: Make, plant: Recorder, brakes: bool) -> None:
    made = drives(brakes=brakes)
    made.set_currents_a(0.3, 0.3, 0.3)
    made.enable()
    made.make_safe()
    made.set_currents_a(0.3, 0.3, 0.3)
    made.put((0.4, 0.4, 0.4))  # in an operator's hands, as at first, until the drives hold them
    made.set_currents_a(0.3, 0.3, 0.3)
    assert plant.held == (3 if brakes else 2)
    assert plant.currents == ([] if brakes else [(0.0, 0.0, 0.0)])


@pytest.mark.parametrize(
    ("kind", "says"),
    [("encoder_lost", "encoder signal of motor2"), ("over_current", "motor2 has tripped: over")],
)
def test_a_trip_names_the_joint_and_stays_until_cause_and_trip_are_gone(
    drives: Make, kind, says: str
) -> None:
    made = drives()
    made.enable()
    made.fail(kind, 2)
    for call in (made.read_counts, lambda: made.set_currents_a(0.0, 0.0, 0.0), made.clear):
        with pytest.raises(DriveAlarm, match=says):
            call()
    made.make_safe()
    with pytest.raises(DriveAlarm, match=says):
        made.enable()
    made.mend(2)
    with pytest.raises(DriveAlarm, match=says):
        made.read_counts()
    made.clear()
    made.enable()
    assert made.read_counts() == (100, 200, 300)


def test_planned_faults_come_and_go_by_the_simulated_time(drives: Make) -> None:
    fault = PlannedFault("encoder_lost", 3, at_s=10 * PERIOD_S, lasts_s=5 * PERIOD_S)
    made = drives(faults=(fault,))
    made.enable()
    for _ in range(10):
        made.set_currents_a(0.0, 0.0, 0.0)
    with pytest.raises(DriveAlarm, match="motor3"):
        made.set_currents_a(0.0, 0.0, 0.0)
    made.make_safe()
    for _ in range(5):
        made.set_currents_a(0.0, 0.0, 0.0)
    made.clear()
    made.enable()
