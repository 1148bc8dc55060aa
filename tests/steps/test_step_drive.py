"""The simulated drive: what counts as a step, what is lost, and when it trips."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.step_drive import DriveLimits, SimulatedDrive

WIDTH_NS, SETTLED_NS = 5_000, 1_000_000_000


def pulses(drive: SimulatedDrive, start_ns: int, period_ns: int, count: int) -> None:
    for t_ns in range(start_ns, start_ns + count * period_ns, period_ns):
        drive.rise(t_ns)
        drive.fall(t_ns + WIDTH_NS)


@pytest.fixture
def drive() -> SimulatedDrive:
    drive = SimulatedDrive()
    drive.set_enabled(True, 0)
    drive.set_direction(True, 0)
    return drive


def test_counts_rising_edges_by_direction(drive: SimulatedDrive) -> None:
    pulses(drive, SETTLED_NS, 100_000, 7)
    drive.set_direction(False, SETTLED_NS + 10**9)
    pulses(drive, SETTLED_NS + 2 * 10**9, 100_000, 3)
    assert (drive.position_steps, drive.edges, drive.lost) == (4, 10, 0)


def test_a_mirrored_motor_counts_the_other_way() -> None:
    drive = SimulatedDrive(inverted=True)
    drive.set_enabled(True, 0)
    drive.set_direction(True, 0)
    pulses(drive, SETTLED_NS, 100_000, 2)
    assert drive.position_steps == -2


def test_ignores_steps_until_enabled_for_long_enough(drive: SimulatedDrive) -> None:
    pulses(drive, 100_000_000, 100_000, 5)
    assert (drive.position_steps, drive.lost) == (0, 5)
    drive.set_enabled(False, SETTLED_NS)
    pulses(drive, SETTLED_NS + 1, 100_000, 5)
    assert (drive.position_steps, drive.lost) == (0, 10)


@pytest.mark.parametrize("width_ns", [999, 1_000])
def test_a_pulse_too_short_is_none(drive: SimulatedDrive, width_ns: int) -> None:
    drive.rise(SETTLED_NS)
    drive.fall(SETTLED_NS + width_ns)
    assert drive.position_steps == (1 if width_ns >= 1_000 else 0)
    assert drive.lost == 1 - drive.position_steps


@pytest.mark.parametrize("after_ns", [1_999, 2_000])
def test_direction_needs_its_set_up_time(drive: SimulatedDrive, after_ns: int) -> None:
    drive.set_direction(False, SETTLED_NS)
    drive.rise(SETTLED_NS + after_ns)
    assert drive.lost == (1 if after_ns < 2_000 else 0)


@pytest.mark.parametrize("pause_ns", [999, 1_000])
def test_a_pause_too_short_hides_the_next_pulse(drive: SimulatedDrive, pause_ns: int) -> None:
    pulses(drive, SETTLED_NS, 100_000, 1)
    drive.rise(SETTLED_NS + WIDTH_NS + pause_ns)
    assert drive.lost == (1 if pause_ns < 1_000 else 0)


def test_starts_at_once_at_ten_kilohertz_but_not_at_sixty(drive: SimulatedDrive) -> None:
    pulses(drive, SETTLED_NS, 100_000, 2000)
    assert drive.lost == 0
    pulses(drive, 10 * SETTLED_NS, 16_000, 2000)
    assert drive.lost > 0


def test_a_ramp_reaches_what_a_jump_does_not(drive: SimulatedDrive) -> None:
    t_ns, rate_hz = SETTLED_NS, 1_000.0
    while rate_hz < 50_000.0:
        drive.rise(t_ns)
        drive.fall(t_ns + WIDTH_NS)
        period_s = 1.0 / rate_hz
        rate_hz += 1e6 * period_s
        t_ns += round(period_s * 1e9)
    pulses(drive, t_ns, 20_000, 2000)
    assert drive.lost == 0


def test_jitter_of_a_tenth_loses_nothing(drive: SimulatedDrive) -> None:
    t_ns = SETTLED_NS
    for index in range(2000):
        drive.rise(t_ns)
        drive.fall(t_ns + WIDTH_NS)
        t_ns += 90_000 if index % 2 else 110_000
    assert drive.lost == 0


def test_a_burst_loses_steps_and_trips(drive: SimulatedDrive) -> None:
    pulses(drive, SETTLED_NS, 100_000, 500)
    pulses(drive, SETTLED_NS + 10**8, 10_000, 1000)
    assert drive.lost >= drive.limits.following_error_steps
    assert drive.alarm
    stuck = drive.position_steps
    pulses(drive, 5 * SETTLED_NS, 1_000_000, 5)
    assert drive.position_steps == stuck


def test_a_trip_ends_with_enable_taken_away() -> None:
    drive = SimulatedDrive(DriveLimits(enable_ns=0))
    drive.set_enabled(True, 0)
    drive.trip()
    assert drive.alarm
    drive.set_enabled(False, SETTLED_NS)
    assert not drive.alarm


def test_a_motor_that_slips_is_behind_and_goes_on() -> None:
    drive = SimulatedDrive()
    drive.set_enabled(True, 0)
    drive.set_direction(True, 300_000_000)
    edges = range(301_000_000, 311_000_000, 1_000_000)
    for t_ns in edges:
        drive.rise(t_ns)
        drive.fall(t_ns + 5_000)
    drive.slip(100)
    assert (drive.position_steps, drive.lost, drive.alarm) == (10 - 100, 100, False)
    drive.rise(312_000_000)
    assert drive.position_steps == 11 - 100


def test_a_motor_that_is_held_fast_does_not_turn() -> None:
    drive = SimulatedDrive()
    drive.set_enabled(True, 0)
    drive.set_direction(True, 300_000_000)
    drive.stalled = True
    drive.rise(301_000_000)
    drive.fall(301_005_000)
    assert (drive.position_steps, drive.lost, drive.edges) == (0, 1, 1)
    drive.stalled = False
    drive.rise(302_000_000)
    assert drive.position_steps == 1
