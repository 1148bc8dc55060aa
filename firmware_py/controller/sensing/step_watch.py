"""Sees lost steps while the robot runs: compares where the sensors say it is with the counts.

The range expected from the edges really sent is taken off every good one. What is left is
the model's error, which changes slowly, the sensors' noise, and steps that were lost. So the
median over the last `NOW_S` is compared with the median over some seconds before, and the
difference, through the linkage's derivatives, becomes steps of each motor. A jump shows at
once, a motor that rests as soon as its counter has gone on far enough.

A difference is a loss when it is larger than noise makes it in a week (`LEAST_M`), and twice
as large as anything in the last minutes: play, wrong lengths, a sensor's scale and latency
come back with every lap of a path. Until that is known, more is asked for (`FIRST_M`).
Whether a motor, a sensor or the drives' power is the cause is compared in sensing/cause.py.
`benchmarks/endurance/step_watch.py` prints what is seen, how soon, at which speed.

What is lost slower than the window before is long is seen once the arms rest (at_rest.py).

Limits: what creeps by less than that is left to the diagnosis, and so is a disagreement that was
there from the start. With one sensor missing nothing is seen.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.steps.contract import Counts, Ticks
from deltactl.firmware_py.controller.sensing.at_rest import NOW_S, AtRest
from deltactl.firmware_py.controller.sensing.cause import causes
from deltactl.firmware_py.feedback.residuals import Expectation, Residuals
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import ns
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.robot import AXES, FloatArray

PLAUSIBLE_S = (0.03, 0.5)
ONSETS_S = (0.3, 0.45, 0.7, 1.0, 1.5, 2.0)
"""Before now: when steps may have been lost."""
AS_WELL = 1.05
"""A sum of squares larger by this share is no worse: of some 400 readings chance makes it so."""


def late_s(rows: Residuals, now_ns: int) -> float:
    """By how much readings would have to be late; 0 where lost steps explain the rows better."""
    here = np.stack([rows.axis == axis for axis in range(len(AXES))], axis=1).astype(np.float64)
    late = np.column_stack([here, -rows.rate_mps])
    found, cost = _fit(late, rows.excess_m)
    since = (rows.t_ns >= now_ns - ns(onset) for onset in ONSETS_S)
    lost = min(
        _fit(np.hstack([here, rows.slope_m * after[:, np.newaxis]]), rows.excess_m)[1]
        for after in since
    )
    least_s, most_s = PLAUSIBLE_S
    seconds = float(found[-1])
    return seconds if least_s <= seconds <= most_s and cost <= AS_WELL * lost else 0.0


def _fit(columns: FloatArray, seen_m: FloatArray) -> tuple[FloatArray, float]:
    """Coefficients, and the sum of squares that is left."""
    found = np.linalg.lstsq(columns, seen_m, rcond=1e-9)[0]
    return found, float(np.sum((seen_m - columns @ found) ** 2))


BEFORE_S = (0.45, 3.0)
"""The window compared with, from so long ago to so long ago."""
LOOK_S = 0.08
READINGS_NEEDED = 6
LOOKS_IN_A_ROW = 2
LEAST_M, FIRST_M = 0.0042, 0.008
"""Way of an elbow. With 1.5 mm of noise a difference scatters by 0.5 to 0.7 mm."""
NOISE_TIMES = 6.0
"""A loss is so many times the scatter of what is made of the noise in this pose: where the arms
lie level, the sensors see an arm turn ten times worse than elsewhere."""
TIMES_USUAL = 2.0
"""A loss is so many times the largest difference that was no loss."""
USUAL_S = 90.0
"""Which is forgotten with this time constant."""
PATIENCE_S = 2.0
"""A difference is usual only after it has not become a loss for so long."""


@dataclass(frozen=True, slots=True)
class StepLoss:
    """Steps of one motor (1 to 3) that were sent but not made (negative: made but not sent).

    Or what else it may be that the sensors hold against the counts, see sensing/cause.py.
    """

    motor: int
    """0 where no motor can be the cause."""
    steps: int
    elbow_m: float
    all_three: bool = False
    """All arms are away from their counts at once, which motors seldom do."""
    late_s: float = 0.0
    """Readings so late would look the same; 0 where they would not."""
    sensors: tuple[tuple[int, float], ...] = ()
    """Sensors (0 to 2) that would look the same if they read wrong, and by how much [m]."""

    def says(self) -> str:
        """One line."""
        said = self._or_else(self._lost()) if self.motor else self._no_motor("")
        if not self.late_s:
            return said
        return (
            f"{said.removesuffix('?')}, or are the readings {self.late_s:.2f} s late, which"
            " the robot file does not know? 'deltactl diagnose' on this recording tells"
        )

    def moved_at_rest(self) -> str:
        """One line, of a robot that should be still."""
        if not self.motor:
            return self._no_motor("while the robot stood still, ")
        cause = "drive power lost?" if self.all_three else "pushed, or slipped?"
        return self._or_else(
            f"an arm moved while the robot stood still: the sensors see motor{self.motor} about"
            f" {abs(self.steps)} steps ({abs(self.elbow_m) * 1e3:.0f} mm at the elbow) from its"
            f" counts ({cause})"
        )

    def _lost(self) -> str:
        if self.all_three:
            return (
                "lost steps: the sensors see all three arms away from their counts,"
                f" motor{self.motor} by about {abs(self.steps)} steps"
                f" ({abs(self.elbow_m) * 1e3:.0f} mm at the elbow): drive power lost?"
            )
        return (
            f"lost steps: the sensors see motor{self.motor} about {abs(self.steps)} steps"
            f" ({abs(self.elbow_m) * 1e3:.0f} mm at the elbow)"
            f" {'behind' if self.steps > 0 else 'ahead of'} its counts"
        )

    def _or_else(self, of_motor: str) -> str:
        """A motor, and what its loss is not distinguishable from."""
        wrong = [reads_wrong(*one) for one in self.sensors]
        if not wrong:
            return of_motor
        return ", or ".join([of_motor.removesuffix("?"), *wrong]) + " (they look the same here)"

    def _no_motor(self, when: str) -> str:
        if not self.sensors:
            return (
                f"{when}the sensors contradict the counts and each other as no single cause would:"
                " look at the sensors ('deltactl status sensors'), then at the motors"
            )
        named = ", or ".join(reads_wrong(*one) for one in self.sensors)
        return (
            f"{when}{named}, which the two other sensors and the counts contradict: look what is in"
            " front of it and on its glass, and see 'deltactl status sensors'"
        )


def reads_wrong(axis: int, range_m: float) -> str:
    """'sensor x reads 46 mm too much'."""
    much = "too much" if range_m > 0.0 else "too little"
    return f"sensor {AXES[axis]} reads {abs(range_m) * 1e3:.0f} mm {much}"


@dataclass(frozen=True, slots=True, eq=False)
class Moved:
    """What the windows say of the arms."""

    angles_rad: FloatArray
    """How far they turned beyond the edges, (3,)."""
    scatter_rad: FloatArray
    """Standard deviation of that by the readings' noise, (3,): that of a median, in this pose."""
    change_m: FloatArray
    """Change of each range beyond the edges, (3,), which `angles_rad` would make."""
    range_scatter_m: FloatArray
    """Standard deviation of that, (3,)."""
    slopes_m: FloatArray
    """Change of each range with a radian of each arm, (3, 3)."""


class Usual:
    """The largest difference that turned out to be none, slowly forgotten."""

    def __init__(self) -> None:
        self.largest_m = FIRST_M / TIMES_USUAL
        self._looks: deque[tuple[int, float]] = deque()

    def limit_m(self) -> float:
        """From here on it is a loss."""
        return max(LEAST_M, TIMES_USUAL * self.largest_m)

    def note(self, now_ns: int, elbow_m: float) -> None:
        """A difference that is no loss so far."""
        self.largest_m *= math.exp(-LOOK_S / USUAL_S)
        self._looks.append((now_ns, abs(elbow_m)))
        while self._looks[0][0] < now_ns - ns(PATIENCE_S):
            self.largest_m = max(self.largest_m, self._looks.popleft()[1])

    def forgive(self) -> None:
        """The last looks saw a loss grow: they say nothing about what is usual."""
        self._looks.clear()


class StepWatch:
    """Fed with edges and readings (the latter from any thread); `look` judges now and then."""

    def __init__(self, robot: RobotFile):
        self._robot = robot
        self._expected = Expectation(robot)
        self._step_rad = robot.drive.rad_per_step
        self._elbows_m = np.broadcast_to(np.asarray(robot.geometry.upper_arm_m), (3,))
        self._blind = robot.sensors is None
        self._readings: deque[Reading] = deque(maxlen=1000)
        self._at_rest = AtRest(robot)
        self.reset((0, 0, 0), 0)

    def homed(self, counts: Counts, now_ns: int, ranges_m: FloatArray) -> None:
        """Begin afresh at home, where the sensors said this: (3,), NaN for those that did not."""
        self.reset(counts, now_ns)
        self._at_rest.homed(self._expected.excess_m(counts, ranges_m))

    def reset(self, counts: Counts, now_ns: int) -> None:
        """Begin afresh: the motors are where the counters say."""
        self._expected.reset(counts, now_ns)
        self._counts = np.array(counts, dtype=np.int64)
        self._still_ns = now_ns
        self._at_rest.moved()
        self._rows = Residuals.none()
        self._looked_ns = now_ns
        self._suspected = 0
        self._usual = Usual()
        self._readings.clear()

    def forgive(self) -> None:
        """Take what was found as given from now on."""
        self._rows = Residuals.none()
        self._suspected = 0
        self._usual.forgive()
        self._at_rest.homed(None)

    def sent(self, ticks: Ticks) -> None:
        """Edges really sent."""
        if len(ticks):
            self._expected.sent(ticks)
            self._counts = self._counts + ticks.steps.sum(axis=0, dtype=np.int64)
            self._still_ns = int(ticks.due_ns[-1])
            self._at_rest.moved()

    def reading(self, reading: Reading) -> None:
        """A sample of a sensor."""
        if reading.gate is Gate.GOOD:
            self._readings.append(reading)

    def look(self, now_ns: int) -> StepLoss | None:
        """What is found, at most every `LOOK_S`; all edges up to `now_ns` must have been given."""
        if self._blind or now_ns - self._looked_ns < ns(LOOK_S):
            return None
        self._looked_ns = now_ns
        new = [self._readings.popleft() for _ in range(len(self._readings))]
        rows = self._rows.and_then(self._expected.residuals(new))
        self._rows = rows.since(now_ns - ns(BEFORE_S[1]))
        self._expected.forget(now_ns)
        loss = self._compare(now_ns) or self._crept(now_ns)
        self._suspected = self._suspected + 1 if loss else 0
        if loss is None or self._suspected < LOOKS_IN_A_ROW:
            return None
        return replace(loss, late_s=late_s(self._rows, now_ns))

    def _crept(self, now_ns: int) -> StepLoss | None:
        off = self._at_rest.off(self._rows, self._still_ns, now_ns)
        return None if off is None else self._named(*off)

    def _compare(self, now_ns: int) -> StepLoss | None:
        moved = self._moved(now_ns)
        if moved is None:
            return None
        moved_rad = moved.angles_rad
        elbows_m = moved_rad * self._elbows_m
        worst = int(np.argmax(np.abs(elbows_m)))
        elbow_m = float(elbows_m[worst])
        if abs(elbow_m) < self._usual.limit_m():
            self._usual.note(now_ns, elbow_m)
            return None
        if abs(moved_rad[worst]) < NOISE_TIMES * moved.scatter_rad[worst]:
            return None
        return self._named(moved.change_m, moved.range_scatter_m, moved.slopes_m)

    def _named(self, change_m: FloatArray, scatter_m: FloatArray, slopes_m: FloatArray) -> StepLoss:
        """What explains it, by one comparison of all single causes."""
        due_rad = self._counts * self._step_rad
        found = causes(self._robot, due_rad, change_m, scatter_m, slopes_m)
        sensors = tuple((one.place, one.range_m) for one in found if one.kind == "sensor")
        turned = next((one for one in found if one.kind in ("motor", "power")), None)
        if turned is None:
            return StepLoss(0, 0, 0.0, sensors=sensors)
        angle_rad = float(turned.angles_rad[turned.place])
        return StepLoss(
            turned.place + 1,
            round(-angle_rad / self._step_rad),
            angle_rad * float(self._elbows_m[turned.place]),
            turned.kind == "power",
            sensors=sensors,
        )

    def _moved(self, now_ns: int) -> Moved | None:
        """How far the arms are now from where they were, beyond the edges."""
        rows = self._rows
        newest = rows.t_ns >= now_ns - ns(NOW_S)
        before = rows.t_ns < now_ns - ns(BEFORE_S[0])
        change_m, scatter_m, slopes_m = np.empty(3), np.empty(3), np.empty((3, 3))
        for axis in range(3):
            mine = rows.axis == axis
            now, then = mine & newest, mine & before
            now_m, then_m = rows.excess_m[now], rows.excess_m[then]
            if min(len(now_m), len(then_m)) < READINGS_NEEDED:
                return None
            usually_m = _median(then_m)
            change_m[axis] = _median(now_m) - usually_m
            spread_m = MAD_TO_SIGMA * _median(np.abs(then_m - usually_m))
            scatter_m[axis] = spread_m * math.sqrt(0.5 * math.pi / len(now_m))
            slopes_m[axis] = rows.slope_m[now].mean(axis=0)
        try:
            inverse = np.linalg.inv(slopes_m)
        except np.linalg.LinAlgError:
            return None
        scatter_rad = np.sqrt(inverse**2 @ scatter_m**2)
        return Moved(inverse @ change_m, scatter_rad, change_m, scatter_m, slopes_m)


def _median(values: FloatArray) -> float:
    """As np.median, which takes ten times as long for so few."""
    ordered = np.sort(values).tolist()
    middle = len(ordered) // 2
    return float(0.5 * (ordered[middle] + ordered[-middle - 1]))
