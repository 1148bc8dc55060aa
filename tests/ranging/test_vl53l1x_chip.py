"""The chip model against the emulator checklist of the facts sheet, over smbus2 messages."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from smbus2 import i2c_msg

from deltactl.drivers.fakes.ranging_bench import ChipBench
from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise


def test_it_is_silent_for_its_boot_time_and_while_held_in_reset(one: ChipBench) -> None:
    one.wait(0.00119)
    assert one.silent()
    one.wait(0.00002)
    assert not one.silent()
    one.chip.set_xshut(False)
    assert one.silent()
    one.wait(1.0)
    assert one.silent()
    one.chip.set_xshut(True)
    assert one.silent()
    one.wait(0.00121)
    assert not one.silent()


def test_boot_leaves_the_reset_values(one: ChipBench) -> None:
    one.wait(0.002)
    assert one.read(0x010F, 3) == bytes([0xEA, 0xCC, 0x10])
    assert one.read(0x00E5) == b"\x03"
    assert one.read(0x0030) == b"\x11"
    assert one.read(0x0031) == b"\x02"
    assert one.read(0x0001) == b"\x29"
    assert one.read(0x0006, 2) == b"\xbc\xcc"


def test_the_pointer_moves_on_and_stays_between_messages(one: ChipBench) -> None:
    one.wait(0.002)
    one.write(0x0072, 1, 2, 3, 4)
    one.bus.i2c_rdwr(i2c_msg.write(0x29, [0x00, 0x72]))
    first, second = i2c_msg.read(0x29, 2), i2c_msg.read(0x29, 2)
    one.bus.i2c_rdwr(first)
    one.bus.i2c_rdwr(second)
    assert bytes(first) + bytes(second) == bytes([1, 2, 3, 4])


def test_registers_outside_its_space_read_nothing_and_keep_nothing(one: ChipBench) -> None:
    one.wait(0.002)
    one.write(0x01FE, 7, 8, 9)
    assert one.read(0x01FE, 4) == bytes([7, 8, 0, 0])


def test_results_and_identity_are_read_only(one: ChipBench) -> None:
    one.wait(0.002)
    before = one.read(0x0088, 18), one.read(0x010F, 3)
    one.write(0x0088, *[0xAA] * 18)
    one.write(0x010F, 1, 2, 3)
    assert (one.read(0x0088, 18), one.read(0x010F, 3)) == before


def test_a_new_address_holds_from_the_next_message_until_a_reset(one: ChipBench) -> None:
    one.wait(0.002)
    one.write(0x0001, 0x31)
    assert one.silent()
    one.address = 0x31
    assert not one.silent()
    one.chip.brown_out()
    one.wait(0.002)
    assert one.silent()
    one.address = 0x29
    assert not one.silent()


def test_a_sample_comes_after_the_range_and_then_once_a_period(one: ChipBench) -> None:
    one.start()
    range_s = (82 * 48.81 + 111 * 36.61 + 4528) * 1e-6
    one.wait(range_s - 0.0002)
    assert one.flag() == 0
    one.wait(0.0004)
    assert one.flag() == 1
    assert one.stream() == 0
    one.wait(0.02 - 0.0004)
    assert one.stream() == 0
    one.wait(0.0004)
    assert one.stream() == 1


def test_the_distance_is_averaged_over_the_last_two_phases(one: ChipBench) -> None:
    one.start()
    started_ns = one.clock.now_ns()
    one.wait(0.02)
    one.stream()
    (start_ns, end_ns), *_ = one.windows
    assert end_ns - start_ns == pytest.approx((82 * 48.81 + 111 * 36.61) * 1e3, rel=1e-3)
    assert start_ns - started_ns == pytest.approx(4_528_000, abs=10)


def test_a_period_shorter_than_the_range_is_the_range(one: ChipBench) -> None:
    one.set_up(period_ms=5)
    one.write(0x0087, 0x40)
    one.wait(12.6e-3 * 10 + 0.001)
    one.stream()
    assert one.chip.samples == 10


def test_a_slow_oscillator_makes_everything_slower() -> None:
    one = ChipBench(oscillator_error=0.05)
    one.start()
    one.wait(2.1 + 0.0126)
    one.stream()
    assert one.chip.samples == 100


def test_the_stream_count_wraps_to_128(one: ChipBench) -> None:
    one.start()
    one.wait(0.0126)
    counts = []
    for _ in range(520):
        one.wait(0.02)
        counts.append(one.stream())
    expected = [*range(1, 256), *range(128, 256), *range(128, 256), *range(128, 256)]
    assert counts == expected[:520]


def test_the_flag_follows_its_polarity_and_the_clear(one: ChipBench) -> None:
    one.start()
    one.wait(0.02)
    assert one.flag() == 1
    one.write(0x0086, 0x01)
    assert one.flag() == 0
    one.write(0x0030, 0x11)
    assert one.flag() == 1
    one.wait(0.02)
    assert one.flag() == 0
    one.write(0x0086, 0x01)
    assert one.flag() == 1


def test_single_shot_makes_one_sample(one: ChipBench) -> None:
    one.set_up()
    one.write(0x0087, 0x10)
    one.wait(1.0)
    one.stream()
    assert one.chip.samples == 1
    assert not one.chip.ranging


@pytest.mark.parametrize("stop", [0x00, 0x80])
def test_stop_and_abort_end_ranging_and_a_start_counts_anew(one: ChipBench, stop: int) -> None:
    one.start()
    one.wait(0.1)
    one.write(0x0087, stop)
    made = one.chip.samples
    one.wait(1.0)
    one.stream()
    assert one.chip.samples == made
    one.write(0x0087, 0x40)
    one.wait(0.02)
    assert one.stream() == 0


def test_a_start_is_ignored_while_parameters_are_on_hold(one: ChipBench) -> None:
    one.set_up()
    one.write(0x0082, 0x01)
    one.write(0x0087, 0x40)
    assert not one.chip.ranging
    one.write(0x0082, 0x00)
    one.write(0x0087, 0x40)
    assert one.chip.ranging


def test_distances_are_whole_millimetres(one: ChipBench) -> None:
    one.true_m = 0.43251
    one.start()
    one.wait(0.02)
    assert one.distance_mm() == 433
    assert one.status() == 9


def test_no_target_too_far_and_too_near_have_their_codes(one: ChipBench) -> None:
    one.start()
    codes = []
    for true_m in (math.inf, 1.6, -0.01, 0.5):
        one.true_m = true_m
        one.wait(0.02)
        codes.append(one.status())
    assert codes == [4, 5, 8, 9]


def test_sunlight_raises_sigma_and_scatter_until_the_chip_gives_up() -> None:
    one = ChipBench(noise=RangeNoise(sigma_m=0.001, seed=4))
    one.true_m = 1.2
    one.start()

    def spread() -> tuple[float, float]:
        distances = []
        for _ in range(300):
            one.wait(0.02)
            distances.append(one.distance_mm())
        mean = sum(distances) / 300
        sigma_mm = int.from_bytes(one.read(0x0092, 2), "big") / 4
        return math.sqrt(sum((d - mean) ** 2 for d in distances) / 300), sigma_mm

    dark, dark_sigma = spread()
    one.chip.scene.ambient_mcps = 100.0
    bright, bright_sigma = spread()
    assert bright > 3 * dark
    assert bright_sigma > 3 * dark_sigma
    assert one.status() == 9
    one.chip.scene.ambient_mcps = 1000.0
    one.wait(0.02)
    assert one.status() == 6


def test_a_dark_target_gives_less_signal(one: ChipBench) -> None:
    one.start()
    one.wait(0.02)
    white = int.from_bytes(one.read(0x0098, 2), "big")
    one.chip.scene.reflectance = 0.25
    one.wait(0.02)
    assert int.from_bytes(one.read(0x0098, 2), "big") == pytest.approx(white / 4, rel=0.01)


def test_noise_has_the_size_and_correlation_asked_for_and_repeats() -> None:
    noise = RangeNoise(sigma_m=0.01, correlation=0.6, seed=3)

    def run(polls: int) -> list[int]:
        one = ChipBench(noise=noise)
        one.start()
        found = []
        for _ in range(polls):
            one.wait(0.02)
            found.append(one.distance_mm())
        return found

    first = run(4000)
    assert run(50) == first[:50]
    mean = sum(first) / len(first)
    deviations = [d - mean for d in first]
    variance = sum(d * d for d in deviations) / len(deviations)
    assert math.sqrt(variance) == pytest.approx(10.0, rel=0.1)
    lagged = sum(a * b for a, b in pairwise(deviations))
    assert lagged / len(deviations) / variance == pytest.approx(0.6, abs=0.06)


def test_samples_nobody_reads_change_nothing_about_those_somebody_does() -> None:
    often, seldom = ChipBench(noise=RangeNoise(seed=9)), ChipBench(noise=RangeNoise(seed=9))
    for one in (often, seldom):
        one.start()
    for _ in range(100):
        often.wait(0.02)
        often.distance_mm()
    seldom.wait(2.0)
    assert seldom.distance_mm() == often.distance_mm()
    assert seldom.stream() == often.stream()
    assert len(seldom.windows) == 1


def test_outliers_come_at_their_rate() -> None:
    one = ChipBench(noise=RangeNoise(sigma_m=0.001, outlier_rate=0.05, outlier_m=0.2, seed=2))
    one.start()
    far = 0
    for _ in range(2000):
        one.wait(0.02)
        far += abs(one.distance_mm() - 500) > 10
    assert 60 < far < 130
