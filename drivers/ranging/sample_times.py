"""When a sample was taken, as best as a polling driver can know it.

A sensor ranges at its own pace. What is certain: a new sample became ready between the last
poll that did not show it and the first that did, and the samples are one period apart, which
the chip keeps to some percent. So every poll narrows an interval for the instant and, over
many samples, one for the period. The estimate runs with the period from the known start and
is moved only as far as these intervals demand: it is exact for a sensor that keeps its
nominal time, never further off than the distance of two polls, and after the polls have
drifted through the period of the sensor once, a small part of that.

The time of a reading is the middle of the phases A and B, the last of a range (those before
calibrate). What the chip does after phase B is not known and stays in as a constant latency.
"""

from __future__ import annotations

from deltactl.foundation.clock import NS_PER_S

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
            self._believe_polls(after_ns, before_ns)
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

    def _believe_polls(self, after_ns: int, before_ns: int) -> None:
        """What was believed contradicts the polls: the period changed, or a count was wrong."""
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
