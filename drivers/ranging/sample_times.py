"""When a sample was taken, as best as a polling driver can know it.

A sensor ranges at its own pace. Two things are known: it was started at a known instant and
then ranges once in a period (its oscillator is off by up to some percent), and a new sample
became ready between the last poll that did not show it and the poll that did. The estimate
runs with the period, is clipped to that interval, and learns the period from how much had to
be clipped. Its error is never more than the distance of two polls; once the polls have
drifted through the period of the sensor it is a small part of that.

The time of a reading is the middle of the phases A and B, the last of a range (the phases
before them calibrate). What the chip does after phase B is not known (some 0.1 ms) and stays
in, as a constant latency.
"""

from __future__ import annotations

from foundation.clock import NS_PER_S

GAIN = 0.1
"""Part of a clipped error that is blamed on the period; 1 / samples to learn it."""
LARGEST_PERIOD_ERROR = 0.1
"""The slow oscillator is calibrated by the chip itself; more than this is no drift."""


class SampleTimes:
    """Estimates when each sample of one sensor became ready."""

    def __init__(self, period_ns: int, range_ns: int, collection_ns: int):
        self._nominal_ns = period_ns
        self._range_ns = range_ns
        self._collection_ns = collection_ns
        self._period_ns = float(period_ns)
        self._ready_ns = 0.0
        self._rate_from_ns = 0
        self._rate_samples = 0
        self.measured_hz: float | None = None
        """Samples per second over the last five seconds or more."""

    def started(self, t_ns: int) -> None:
        """Ranging was started at `t_ns`; its first sample (number 0) is ready a range later."""
        self._period_ns = float(self._nominal_ns)
        self._ready_ns = float(t_ns + self._range_ns)
        self._rate_from_ns, self._rate_samples = t_ns, 0
        self.measured_hz = None

    def plausible(self, samples: int, now_ns: int) -> bool:
        """Whether so many samples can have come since the last one seen (two more or fewer)."""
        fits = (now_ns - self._ready_ns) / self._period_ns
        return abs(self._unwrap(samples, now_ns) - fits) <= 2.0 + LARGEST_PERIOD_ERROR * fits

    def middle_ns(self, samples: int, after_ns: int, before_ns: int) -> int:
        """Middle of the integration of a sample, `samples` after the last one seen.

        It was not there at `after_ns` and was there at `before_ns`.
        """
        samples = self._unwrap(samples, before_ns)
        expected_ns = self._ready_ns + samples * self._period_ns
        ready_ns = min(max(expected_ns, float(after_ns)), float(before_ns))
        self._learn(ready_ns - expected_ns, samples)
        self._ready_ns = ready_ns
        self._count(samples, before_ns)
        return round(ready_ns) - self._collection_ns // 2

    def _unwrap(self, samples: int, before_ns: int) -> int:
        """The stream count repeats after 128 samples: take the number that fits the time."""
        fits = (before_ns - self._ready_ns) / self._period_ns
        return samples + 128 * max(0, round((fits - samples) / 128))

    def _learn(self, error_ns: float, samples: int) -> None:
        slack_ns = LARGEST_PERIOD_ERROR * self._nominal_ns
        learnt_ns = self._period_ns + GAIN * error_ns / samples
        self._period_ns = min(
            max(learnt_ns, self._nominal_ns - slack_ns), self._nominal_ns + slack_ns
        )

    def _count(self, samples: int, now_ns: int) -> None:
        self._rate_samples += samples
        since_ns = now_ns - self._rate_from_ns
        if since_ns >= 5 * NS_PER_S:
            self.measured_hz = self._rate_samples * NS_PER_S / since_ns
            self._rate_from_ns, self._rate_samples = now_ns, 0
