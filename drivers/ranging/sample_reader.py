"""Reads one distance sensor: new samples only, with time, gate and offset; and how it fares.

When a sample was taken is known as best as a polling driver can know it. A sensor ranges at its own
pace. What is certain: a new sample became ready between the last poll that did not show it and the
first that did, and the samples are one period apart, which the chip keeps to some percent. So every
poll narrows an interval for the instant and, over many samples, one for the period. The estimate
runs with the period from the known start and is moved only as far as these intervals demand: it is
exact for a sensor that keeps its nominal time, never further off than the distance of two polls,
and after the polls have drifted through the period of the sensor once, a small part of that. The
time of a reading is the middle of the phases A and B, the last of a range (those before calibrate).
What the chip does after phase B is not known and stays in as a constant latency.

A status of 0 is not proof of a good distance, so jumps are refused too (stm32duino/VL53L1X#7:
short mode returned 22 to 27 mm for a target at 1.8 m with status 0).
"""

from __future__ import annotations

from deltactl.drivers.i2c import TRANSIENT_ERRNOS
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.ranging.registers import RANGE_VALID, RangeTiming, explain, uld_status
from deltactl.drivers.ranging.vl53l1x import RawSample, Vl53l1x, samples_between
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, Clock, ns

LARGEST_PERIOD_ERROR = 0.1
"""The slow oscillator is calibrated by the chip itself; more than this is no drift."""
DRIFT = 1e-3
"""How much the period may change (temperature) while SAMPLES_PER_ANCHOR go by."""
SAMPLES_PER_ANCHOR = 3000
RATE_WINDOW_NS = 5 * NS_PER_S


class SampleTimes:
    """Estimates when each sample of one sensor became ready."""

    def __init__(self, period_ns: int, range_ns: int, collection_ns: int):
        self._nominal_ns = float(period_ns)
        self._range_ns = range_ns
        self._collection_ns = collection_ns
        self.measured_hz: float | None = None
        """Samples per second over the last five seconds or more."""
        self._ready_ns = self._earliest_ns = self._latest_ns = 0.0
        self._anchor_earliest_ns = self._anchor_latest_ns = 0.0
        self._period_ns = self._shortest_ns = self._longest_ns = 0.0
        self._since_anchor = self._rate_from_ns = self._rate_samples = 0
        self.started(0)

    def started(self, t_ns: int) -> None:
        """Ranging was started at `t_ns`; its first sample (number 0) is ready a range later."""
        self._ready_ns = float(t_ns + self._range_ns)
        self._anchor(float(t_ns), t_ns + self._range_ns + self._nominal_ns)
        self._forget_period()
        self._rate_from_ns, self._rate_samples = t_ns, 0
        self.measured_hz = None

    def plausible(self, samples: int, now_ns: int) -> bool:
        """Whether so many samples can have come since the last one seen (two more or fewer)."""
        fits = (now_ns - self._ready_ns) / self._period_ns
        return abs(self._unwrap(samples, now_ns) - fits) <= 2.0 + LARGEST_PERIOD_ERROR * fits

    @property
    def earliest_next_ns(self) -> float:
        """No sample can become ready before this: asking the sensor earlier is in vain."""
        return self._earliest_ns + self._shortest_ns

    def middle_ns(self, samples: int, after_ns: int, before_ns: int) -> int:
        """Middle of the integration of a sample, `samples` after the last one seen.

        It was not there at `after_ns` and was there at `before_ns`.
        """
        samples = self._unwrap(samples, before_ns)
        self._since_anchor += samples
        self._earliest_ns = max(self._earliest_ns + samples * self._shortest_ns, after_ns)
        self._latest_ns = min(self._latest_ns + samples * self._longest_ns, before_ns)
        if self._earliest_ns > self._latest_ns:
            self._follow_polls(after_ns, before_ns)
        expected_ns = self._ready_ns + samples * self._period_ns
        self._ready_ns = min(max(expected_ns, self._earliest_ns), self._latest_ns)
        self._learn_period()
        self._count(samples, before_ns)
        return round(self._ready_ns) - self._collection_ns // 2

    def _unwrap(self, samples: int, before_ns: int) -> int:
        """The stream count repeats after 128 samples: take the number that fits the time."""
        fits = (before_ns - self._ready_ns) / self._period_ns
        return samples + 128 * max(0, round((fits - samples) / 128))

    def _anchor(self, earliest_ns: float, latest_ns: float) -> None:
        """The period is measured from this sample on."""
        self._earliest_ns = self._anchor_earliest_ns = earliest_ns
        self._latest_ns = self._anchor_latest_ns = latest_ns
        self._since_anchor = 0

    def _forget_period(self) -> None:
        self._period_ns = self._nominal_ns
        self._shortest_ns = (1.0 - LARGEST_PERIOD_ERROR) * self._nominal_ns
        self._longest_ns = (1.0 + LARGEST_PERIOD_ERROR) * self._nominal_ns

    def _follow_polls(self, after_ns: int, before_ns: int) -> None:
        """The polls contradict the estimate: the period changed, or a count was wrong."""
        self._anchor(float(after_ns), float(before_ns))
        self._forget_period()

    def _learn_period(self) -> None:
        if self._since_anchor == 0:
            return
        shortest_ns = (self._earliest_ns - self._anchor_latest_ns) / self._since_anchor
        longest_ns = (self._latest_ns - self._anchor_earliest_ns) / self._since_anchor
        self._shortest_ns = max(self._shortest_ns, shortest_ns)
        self._longest_ns = min(self._longest_ns, longest_ns)
        if self._shortest_ns > self._longest_ns:
            self._forget_period()
            self._anchor(self._earliest_ns, self._latest_ns)
        elif not self._shortest_ns <= self._nominal_ns <= self._longest_ns:
            self._period_ns = (self._shortest_ns + self._longest_ns) / 2.0
        if self._since_anchor >= SAMPLES_PER_ANCHOR:
            self._anchor(self._earliest_ns, self._latest_ns)
            self._shortest_ns -= DRIFT * self._nominal_ns
            self._longest_ns += DRIFT * self._nominal_ns

    def _count(self, samples: int, now_ns: int) -> None:
        self._rate_samples += samples
        since_ns = now_ns - self._rate_from_ns
        if since_ns >= RATE_WINDOW_NS:
            self.measured_hz = self._rate_samples * NS_PER_S / since_ns
            self._rate_from_ns, self._rate_samples = now_ns, 0


BELIEVED_AFTER = 3
"""So many readings in a row that agree with each other make a jump a fact."""


class Gatekeeper:
    """Judges the samples of one sensor; a jump is measured from its last good distance."""

    def __init__(self, settings: RangingSettings):
        self._settings = settings
        self._memory_ns = ns(settings.maximum_age_s)
        self._good: tuple[int, float] | None = None
        self._landed_mm = 0.0
        self._landings = 0

    def forget(self) -> None:
        """The sensor was restarted: nothing to compare with."""
        self._good = None
        self._landings = 0

    def judge(self, sample: RawSample, status: int, t_ns: int) -> Gate:
        """The first gate that a sample does not pass, or GOOD."""
        settings = self._settings
        if status != RANGE_VALID:
            return Gate.STATUS
        if sample.signal_mcps < settings.minimum_signal_mcps:
            return Gate.SIGNAL
        if sample.sigma_mm > settings.maximum_sigma_mm:
            return Gate.SIGMA
        if self._jumped(float(sample.distance_mm), t_ns):
            return Gate.JUMP
        self._good = (t_ns, float(sample.distance_mm))
        self._landings = 0
        return Gate.GOOD

    def _jumped(self, distance_mm: float, t_ns: int) -> bool:
        if self._good is None or t_ns - self._good[0] > self._memory_ns:
            return False
        limit_mm = self._settings.maximum_jump_mm
        if abs(distance_mm - self._good[1]) <= limit_mm:
            return False
        again = self._landings > 0 and abs(distance_mm - self._landed_mm) <= limit_mm
        self._landings = self._landings + 1 if again else 1
        self._landed_mm = distance_mm
        return self._landings < BELIEVED_AFTER


AGE_MARGIN_NS = ns(0.02)
FAULTS_IN_A_ROW = 5
"""Hardware-fault statuses in a row before a sensor is restarted."""


class SampleReader:
    """Polls a sensor that ranges. It is asked whether it has a new sample by reading the sample.

    The ready flag is not read: the stream count says the same, survives a lost flag, and
    saves a transaction a poll.
    """

    def __init__(
        self, axis: str, offset_mm: float, sensor: Vl53l1x, clock: Clock, settings: RangingSettings
    ):
        self.offset_mm = offset_mm
        self.trouble = ""
        """What is wrong with it just now, empty when nothing is."""
        self._axis = axis
        self._sensor = sensor
        self._clock = clock
        self._period_ns = round(NS_PER_S / settings.rate_hz)
        self._patience_ns = 2 * self._period_ns + AGE_MARGIN_NS
        self._age_limit_ns = max(ns(settings.maximum_age_s), self._patience_ns)
        self._gatekeeper = Gatekeeper(settings)
        self._times = SampleTimes(self._period_ns, 0, 0)
        self._last_count = self._faults_in_a_row = 0
        self._started_ns = self._changed_ns = self._absent_ns = self._asked_ns = 0

    @property
    def measured_hz(self) -> float | None:
        """Samples per second over the last seconds; None while not yet known."""
        return self._times.measured_hz

    @property
    def ranged_ns(self) -> int:
        """From the last start to the newest sample."""
        return self._changed_ns - self._started_ns

    def set_timing(self, timing: RangeTiming) -> None:
        """How long a range takes in the mode just set."""
        self._times = SampleTimes(self._period_ns, timing.range_ns, timing.collection_ns)

    def started(self) -> None:
        """The sensor was started just now, after a reset."""
        now_ns = self._clock.now_ns()
        self._times.started(now_ns)
        self._gatekeeper.forget()
        self.trouble = ""
        # Sample 0 has the stream count 0 of the sample before the start: it is not reported.
        self._last_count = self._faults_in_a_row = 0
        self._started_ns = self._changed_ns = self._absent_ns = self._asked_ns = now_ns

    def read(self) -> Reading | None:
        """A new sample, or None, also where it is too early for one and the sensor is not asked.

        Raises OSError when the bus fails after its retries.
        """
        before_ns = self._clock.now_ns()
        if before_ns < self._times.earliest_next_ns:
            return None
        self._asked_ns = before_ns
        sample = self._sensor.read_sample()
        if self._implausible(sample):
            before_ns = self._clock.now_ns()
            sample = self._sensor.read_sample()
        if sample.stream_count == self._last_count:
            self._absent_ns = before_ns
            self._rescue_flag(before_ns)
            return None
        return self._take(sample, before_ns)

    def failed(self, error: OSError) -> None:
        """A read failed: it is in trouble until one succeeds."""
        self.trouble = (
            f"no answer at 0x{self._sensor.address:02X} (errno {error.errno}, {error.strerror})"
        )

    def why_restart(self) -> str | None:
        """The reason to restart the sensor now, if there is one.

        A sample is late when a poll that began late did not find it: what passed since then is the
        pause of a busy computer or of the bus, not of the sensor.
        """
        age_ns = self._asked_ns - self._changed_ns
        if age_ns > self._age_limit_ns:
            return self.trouble or f"no new sample for {age_ns / NS_PER_S:.2f} s"
        if self._faults_in_a_row >= FAULTS_IN_A_ROW:
            return self.trouble
        return None

    def _implausible(self, sample: RawSample) -> bool:
        """A stream count that does not fit the time may be a bit flipped on the wire."""
        samples = samples_between(self._last_count, sample.stream_count)
        return samples > 0 and not self._times.plausible(samples, self._clock.now_ns())

    def _rescue_flag(self, now_ns: int) -> None:
        """A lost clear must not stop a sensor: clear again when a sample is overdue."""
        if now_ns - self._changed_ns > self._patience_ns:
            self._sensor.clear_interrupt()

    def _take(self, sample: RawSample, before_ns: int) -> Reading:
        now_ns = self._clock.now_ns()
        samples = samples_between(self._last_count, sample.stream_count)
        t_ns = self._times.middle_ns(samples, self._absent_ns, now_ns)
        self._last_count = sample.stream_count
        self._changed_ns, self._absent_ns = now_ns, before_ns
        self._clear_after_read()
        return self._judged(sample, t_ns)

    def _clear_after_read(self) -> None:
        try:
            self._sensor.clear_interrupt()
        except OSError as error:
            if error.errno not in TRANSIENT_ERRNOS:
                raise
            # The sample is good all the same; the next poll meets the bus again.

    def _judged(self, sample: RawSample, t_ns: int) -> Reading:
        meaning = explain(sample.raw_status)
        self._faults_in_a_row = self._faults_in_a_row + 1 if meaning.hardware_fault else 0
        self.trouble = meaning.says if meaning.hardware_fault else ""
        status = uld_status(sample.raw_status, sample.stream_count)
        return Reading(
            axis=self._axis,
            t_ns=t_ns,
            distance_m=(sample.distance_mm + self.offset_mm) / 1e3,
            status=status,
            raw_status=sample.raw_status,
            signal_mcps=sample.signal_mcps,
            ambient_mcps=sample.ambient_mcps,
            sigma_m=sample.sigma_mm / 1e3,
            stream_count=sample.stream_count,
            gate=self._gatekeeper.judge(sample, status, t_ns),
        )
