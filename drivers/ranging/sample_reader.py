"""Reads one ranging sensor: new samples only, with time, gate and offset; and how it fares.

A status of 0 is not proof of a good distance, so jumps are refused too (stm32duino/VL53L1X#7:
short mode returned 22 to 27 mm for a target at 1.8 m with status 0).
"""

from __future__ import annotations

from deltactl.drivers.i2c import TRANSIENT_ERRNOS
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.ranging.registers import RANGE_VALID, RangeTiming, explain, uld_status
from deltactl.drivers.ranging.sample_times import SampleTimes
from deltactl.drivers.ranging.vl53l1x import RawSample, Vl53l1x, samples_between
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, Clock, ns

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
        self._last_count = 0
        self._started_ns = 0
        self._changed_ns = 0
        self._absent_ns = 0
        self._asked_ns = 0
        self._faults_in_a_row = 0

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
        # Sample 0 cannot be told from the count 0 that stood there before: it is not reported.
        self._last_count = 0
        self._faults_in_a_row = 0
        self._started_ns = self._changed_ns = self._absent_ns = now_ns
        self._asked_ns = now_ns

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
