"""Simulated lines with a drive on each motor's three, over memory that two processes may share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from mmap import mmap
from time import monotonic_ns
from typing import Any, Final, NamedTuple

from deltactl.drivers.fakes.step_drive import SimulatedDrive
from deltactl.drivers.steps.lines import (
    ALARM_BITS,
    ALARM_SHIFT,
    DIRECTION_BITS,
    DIRECTION_SHIFT,
    ENABLE_BIT,
    ESTOP_BIT,
    STEP_BITS,
    SWITCH_SHIFT,
)

Counts = tuple[int, int, int]

ROWS: Final = 65536
"""Length of the history: at 100 us a step, 6.5 s."""
AT_REST_NS: Final = 100_000_000
"""A motor without an edge for longer counts as resting."""
_MARGIN: Final = 64
_NEAR: Final = 4
_ESTOP, _TRIP, _ALARMS, _HEAD, _LOST, _SWITCHED, _EDGES = 0, 1, 2, 3, 4, 7, 8
_SLIP, _STALLED, _ENERGISED = 11, 14, 15
_HELD_UP = 8
"""Beside the trips in their word: slip and stalls have something new."""
_WORDS: Final = 16
BENCH_BYTES: Final = (_WORDS + 4 * ROWS) * 8


class FakeWiring(NamedTuple):
    """Polarities of the simulated robot's wires, and which motors are mounted mirrored."""

    enable_level: int = 1
    estop_level: int = 1
    """Level of the e-stop input while the button is pressed."""
    alarm_level: int = 0
    inverted: int = 0


class BenchMemory:
    """What the drives did, by time, and what is done to them: pressed button, forced trips.

    Rows of the history are (t_ns, position of motor 1, 2, 3), the newest ROWS of them.
    """

    def __init__(self, buffer: bytearray | mmap):
        self.buffer = buffer
        whole = memoryview(buffer)
        self._words = whole[:BENCH_BYTES].cast("q")
        whole.release()

    @property
    def estop_pressed(self) -> bool:
        """Whether the button is pressed."""
        return bool(self._words[_ESTOP])

    @estop_pressed.setter
    def estop_pressed(self, pressed: bool) -> None:
        self._words[_ESTOP] = int(pressed)

    @property
    def energised(self) -> bool:
        """Whether ENA lets the drives hold their motors."""
        return bool(self._words[_ENERGISED])

    @energised.setter
    def energised(self, on: bool) -> None:
        self._words[_ENERGISED] = int(on)

    @property
    def switched(self) -> int:
        """Levels of the outputs that jobs switch, bits as in drivers/steps/lines.py."""
        return self._words[_SWITCHED]

    @switched.setter
    def switched(self, levels: int) -> None:
        self._words[_SWITCHED] = levels

    @property
    def alarms(self) -> int:
        """Tripped drives, a bit each."""
        return self._words[_ALARMS]

    def ask_trips(self, motors: int) -> None:
        """Have drives trip, a bit each, the next time their alarms are read."""
        self._words[_TRIP] |= motors

    def ask_slip(self, motor: int, steps: int) -> None:
        """Have a motor (0 to 2) fall behind the next time alarms are read."""
        self._words[_SLIP + motor] += steps
        self._words[_TRIP] |= _HELD_UP

    def ask_stall(self, motor: int, stalled: bool) -> None:
        """Hold a motor's rotor, or let it go, the next time alarms are read."""
        others = self._words[_STALLED] & ~(1 << motor)
        self._words[_STALLED] = others | int(stalled) << motor
        self._words[_TRIP] |= _HELD_UP

    def take_slip(self, motor: int) -> int:
        """Steps a motor is to fall behind now."""
        steps, self._words[_SLIP + motor] = self._words[_SLIP + motor], 0
        return steps

    def stalled(self, motor: int) -> bool:
        """Whether a motor's rotor is held."""
        return bool(self._words[_STALLED] >> motor & 1)

    def asked_trips(self) -> int:
        """Drives asked to trip, a bit each, and whether slip or stalls have changed."""
        return self._words[_TRIP]

    def done_trips(self) -> None:
        """The drives that were asked to have tripped."""
        self._words[_TRIP] = 0

    def counts(self) -> Counts:
        """Positions now, in microsteps."""
        head = self._words[_HEAD]
        return self._row(head - 1)[1] if head else (0, 0, 0)

    def lost(self) -> Counts:
        """Edges that moved nothing."""
        first, second, third = self._words[_LOST : _LOST + 3]
        return first, second, third

    def edges(self) -> Counts:
        """Rising edges seen."""
        first, second, third = self._words[_EDGES : _EDGES + 3]
        return first, second, third

    def counts_at(self, t_ns: int) -> Counts:
        """Positions at a time; the oldest kept when it lies further back."""
        high = self._words[_HEAD]
        low = oldest = max(0, high - ROWS + _MARGIN)
        for index in range(high - 1, max(low, high - _NEAR) - 1, -1):  # asked for most often
            if self._words[_WORDS + 4 * (index % ROWS)] <= t_ns:
                return self._row(index)[1]
        while low < high:
            middle = (low + high) // 2
            if self._words[_WORDS + 4 * (middle % ROWS)] <= t_ns:
                low = middle + 1
            else:
                high = middle
        if low == oldest:
            return (0, 0, 0) if oldest == 0 else self._row(oldest)[1]
        return self._row(low - 1)[1]

    def step_times(self) -> list[int]:
        """Times [ns] of the rows still kept."""
        head = self._words[_HEAD]
        return [self._row(index)[0] for index in range(max(0, head - ROWS + _MARGIN), head)]

    def publish(self, t_ns: int, drives: Sequence[SimulatedDrive]) -> None:
        """Write down where the drives are (called where they are simulated)."""
        words = self._words
        first, second, third = drives
        at = _WORDS + 4 * (words[_HEAD] % ROWS)
        words[at + 1] = first.position_steps
        words[at + 2] = second.position_steps
        words[at + 3] = third.position_steps
        words[at] = t_ns
        words[_HEAD] += 1

    def newest_ns(self) -> int:
        """Time of the newest row; long ago while there is none."""
        head = self._words[_HEAD]
        return self._row(head - 1)[0] if head else -AT_REST_NS

    def publish_health(self, drives: Sequence[SimulatedDrive]) -> None:
        """Write down alarms and tallies."""
        words = self._words
        first, second, third = drives
        words[_EDGES], words[_LOST] = first.edges, first.lost
        words[_EDGES + 1], words[_LOST + 1] = second.edges, second.lost
        words[_EDGES + 2], words[_LOST + 2] = third.edges, third.lost
        words[_ALARMS] = first.alarm | second.alarm << 1 | third.alarm << 2

    def release(self) -> None:
        """Let go of the block, so that an mmap can be closed."""
        self._words.release()

    def _row(self, index: int) -> tuple[int, Counts]:
        at = _WORDS + 4 * (index % ROWS)
        t_ns, first, second, third = self._words[at : at + 4]
        return t_ns, (first, second, third)


class FakeLines:
    """A LineGroup with three simulated drives, a button and their wires.

    Does not model: time that a write takes, skew between lines written together, bouncing
    contacts, or noise on the inputs.
    """

    def __init__(
        self,
        memory: BenchMemory,
        now_ns: Callable[[], int],
        wiring: FakeWiring = FakeWiring(),  # noqa: B008 (immutable)
        drives: Sequence[SimulatedDrive] | None = None,
    ):
        self.memory = memory
        self.drives = drives or [
            SimulatedDrive(inverted=bool(wiring.inverted >> motor & 1)) for motor in range(3)
        ]
        self.on_alarms: Callable[[int], None] | None = None
        self._now, self._wiring = now_ns, wiring
        self._levels = ENABLE_BIT * (1 - wiring.enable_level)
        self._alarms = 0
        self._corrected_ns = -1

    def write(self, levels: int, mask: int) -> None:
        changed = (self._levels ^ levels) & mask
        if not changed:
            return
        self._levels ^= changed
        t_ns = self._now()
        if changed & STEP_BITS:
            self._step(levels, changed, t_ns)
        if changed & DIRECTION_BITS:
            for motor, drive in enumerate(self.drives):
                bit = 1 << (DIRECTION_SHIFT + motor)
                if changed & bit:
                    drive.set_direction(bool(levels & bit), t_ns)
        if changed & ENABLE_BIT:
            on = bool(levels & ENABLE_BIT) == bool(self._wiring.enable_level)
            for drive in self.drives:
                drive.set_enabled(on, t_ns)
            self.memory.energised = on
            self._health()
        if changed >> SWITCH_SHIFT:
            self.memory.switched = self._levels >> SWITCH_SHIFT << SWITCH_SHIFT

    def read(self) -> int:
        if self.memory.asked_trips():
            self.refresh()
        wiring = self._wiring
        alarms = self._alarms << ALARM_SHIFT
        levels = alarms if wiring.alarm_level else ~alarms & ALARM_BITS
        if self.memory.estop_pressed == bool(wiring.estop_level):
            levels |= ESTOP_BIT
        return levels

    def refresh(self) -> None:
        """Trip the drives that were asked to, make motors slip, hold them up."""
        asked, slipped = self.memory.asked_trips(), False
        for motor, drive in enumerate(self.drives):
            if asked >> motor & 1:
                drive.trip()
            drive.stalled = self.memory.stalled(motor)
            if steps := self.memory.take_slip(motor):
                drive.slip(steps)
                slipped = True
        if slipped:
            self._correct(self._now())
        self.memory.done_trips()
        self._health()

    def close(self) -> None:
        """See LineGroup. The drives keep their state, as real ones do."""

    def cycle_power(self) -> None:
        """Every drive's supply off and on again: alarms are gone."""
        for drive in self.drives:
            drive.alarm = False
        self._health()

    def _step(self, levels: int, changed: int, t_ns: int) -> None:
        moved = False
        for motor, drive in enumerate(self.drives):
            if changed >> motor & 1:
                before = drive.position_steps
                if levels >> motor & 1:
                    drive.rise(t_ns)
                else:
                    drive.fall(t_ns)
                moved = moved or before != drive.position_steps
        if moved:
            self.memory.publish(t_ns, self.drives)
        if moved or changed & levels:
            self._health()

    def _correct(self, t_ns: int) -> None:
        """A motor moved without an edge: report it at once where no edge will."""
        newest_ns = self.memory.newest_ns()
        if newest_ns == self._corrected_ns or t_ns - newest_ns >= AT_REST_NS:
            self.memory.publish(t_ns, self.drives)
            self._corrected_ns = t_ns

    def _health(self) -> None:
        self.memory.publish_health(self.drives)
        if self.memory.alarms != self._alarms:
            self._alarms = self.memory.alarms
            if self.on_alarms is not None:
                self.on_alarms(self._alarms)


def of_config(config: dict[str, Any]) -> FakeLines:
    """The lines of the bench whose memory the pulse process was given."""
    memory = BenchMemory(mmap(config["bench"], BENCH_BYTES))
    return FakeLines(memory, monotonic_ns, FakeWiring(*config["wiring"]))
