"""The pulse player: plays ticks at their deadlines, and never two closer than they were planned.

Pure logic over three things it is given: a board (requests in, counters out), a line group
and a clock. `play` is a generator that yields the time at which it wants to go on, so the
same code runs in the pulse process, as a task of a virtual clock, and over gpiozero pins.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Final, NamedTuple

from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.lines import (
    ALARM_SHIFT,
    DIRECTION_BITS,
    DIRECTION_SHIFT,
    ENABLE_BIT,
    ESTOP_BIT,
    STEP_BITS,
    LineGroup,
)


class PlayerSettings(NamedTuple):
    """Timing in ns; masks have a bit for each motor, or for each input line (see lines.py)."""

    pulse_width_ns: int
    direction_setup_ns: int
    minimum_gap_fraction: float
    heartbeat_ns: int
    inverted: int
    """Motors whose positive direction is a low DIR."""
    enable_level: int
    """Level of ENA that energises the drives."""
    input_mask: int
    """Inputs that exist."""
    input_idle: int
    """Levels of the inputs while nothing is wrong."""
    poll_ns: int
    """While waiting for a tick, requests and inputs are looked at this often."""
    check_ahead_ns: int = 0
    """The last look at them comes so long before an edge; 0 is right at the edge."""
    switch_mask: int = 0
    """Outputs that jobs switch, bits as in lines.py."""
    switch_safe: int = 0
    """Their levels whenever the player is stopped or the drives are released."""

    @property
    def cycle_ns(self) -> int:
        """Shortest time between two steps that pulse width, low time and DIR set-up leave."""
        return 2 * self.pulse_width_ns + self.direction_setup_ns


Deltas = tuple[int, int, int]


def _decode(code: int) -> Deltas:
    signs = [-1 if code >> (3 + motor) & 1 else 1 for motor in range(3)]
    first, second, third = (sign * (code >> motor & 1) for motor, sign in enumerate(signs))
    return first, second, third


_DELTAS: Final = tuple(_decode(code) for code in range(64))


class PulsePlayer:
    """Owns lines and counters. `serve` must be called often while nothing is played."""

    def __init__(
        self,
        board: b.Board,
        lines: LineGroup,
        settings: PlayerSettings,
        now_ns: Callable[[], int],
    ):
        self._board, self._words, self._lines = board, board.words, lines
        self._settings, self._now = settings, now_ns
        self._fence = b.Fence()
        self._t_ns = now_ns()
        self._next = self._words[b.PLAYED]
        self._stop_seen = self._words[b.STOP]
        self._directions = 0
        self._last_edge_ns: int | None = None
        self._fell_ns = 0
        self._write_ns = 10**9
        self._last_due_ns = 0
        self._last_gap_ns = 0
        self._offset_ns = 0
        self._fresh = True
        self.near_edge = True
        """Whether the time that `play` last yielded is an edge's, or close before one."""
        self._state = b.DISABLED
        lines.write(0, STEP_BITS | DIRECTION_BITS)
        self._switch(settings.switch_safe, settings.switch_mask)
        self._energise(False)
        self._words[b.ALIVE] = self._t_ns
        self._words[b.MAGIC_WORD] = b.MAGIC

    @property
    def pending(self) -> bool:
        """Whether there are ticks to play, and they may be played."""
        return self._words[b.PUSHED] != self._next and self._state in (b.READY, b.MOVING)

    def play(self) -> Generator[int, None, None]:
        """Play until the queue is empty or the player is stopped; yields wake-up times [ns]."""
        self._fresh, self._offset_ns = True, 0
        while self.pending:
            self._enter(b.MOVING)
            self._fence()
            index = self._next
            slot = index & b.SLOT_MASK
            due_ns, code = self._board.due_ns[slot], self._board.codes[slot]
            plan_ns = self._plan(due_ns)
            turned = self._turned(code)
            if turned != self._directions:
                setup_ns = self._settings.direction_setup_ns
                early_ns = plan_ns - setup_ns - self._settings.check_ahead_ns
                if not (yield from self._wait(early_ns, index)):
                    continue
                self._lines.write(turned, DIRECTION_BITS)
                self._directions = turned
                plan_ns = max(plan_ns, self._now() + setup_ns)
            if (yield from self._wait(plan_ns, index)):
                yield from self._pulse(slot, due_ns, code)
        if self._state == b.MOVING:
            self._enter(b.READY)

    def serve(self) -> bool:
        """Look at requests, inputs and heartbeat; whether ticks may be played afterwards."""
        words = self._words
        self._t_ns = words[b.ALIVE] = self._now()
        if words[b.CLOSE]:
            self.stop(words[b.CLOSE])
        if words[b.STOP] != self._stop_seen:
            self._stop_seen = words[b.STOP]
            self.stop(b.REQUESTED)
        if words[b.COMMAND] != words[b.SERVED]:
            self._obey()
        if self._state != b.STOPPED:
            trip = self._trip()
            if trip:
                self.stop(trip)
            elif self._state == b.MOVING and self._silent():
                self.stop(b.NO_HEARTBEAT)
        return self._state in (b.READY, b.MOVING)

    def stop(self, reason: int) -> None:
        """Forget the queue, latch, and put switched outputs safe; the first reason stays.

        STOPPED is shown last: who reads it may rely on the outputs being safe.
        """
        self._drop()
        if self._state == b.STOPPED:
            return
        self._state = b.STOPPED
        self._words[b.REASON] = reason
        try:
            self._switches_safe(quiet=reason == b.LINE_FAULT)
        finally:
            self._enter(b.STOPPED)

    def make_safe(self, reason: int) -> None:
        """Stop, and leave STEP low. ENA stays as it is: dropping the arms is not safe."""
        self.stop(reason)
        self._switches_safe()
        self._lines.write(0, STEP_BITS)

    def _plan(self, due_ns: int) -> int:
        """When a tick may be played; what the minimum gap adds is slip for all that follow."""
        plan_ns = due_ns + self._offset_ns
        if self._last_edge_ns is None:
            return plan_ns
        gap_ns = due_ns - self._last_due_ns
        if self._fresh:  # due times of another run say nothing about a gap, but its speed does
            gap_ns = min(gap_ns, self._last_gap_ns) if gap_ns > 0 else self._last_gap_ns
        settings = self._settings
        least_ns = max(int(gap_ns * settings.minimum_gap_fraction), settings.cycle_ns)
        earliest_ns = max(self._last_edge_ns + least_ns, self._fell_ns + settings.pulse_width_ns)
        late_ns = earliest_ns - plan_ns
        if late_ns <= 0:
            return plan_ns
        self._offset_ns += late_ns
        self._words[b.SLIP] += late_ns
        return plan_ns + late_ns

    def _wait(self, until_ns: int, index: int) -> Generator[int, None, bool]:
        """Serve until the time has come; False when the tick was dropped meanwhile.

        The last look comes `check_ahead_ns` before, so that it does not make the edge late.
        """
        poll_ns, ahead_ns = self._settings.poll_ns, self._settings.check_ahead_ns
        check_ns = until_ns - ahead_ns
        while True:
            poll_at_ns = self._t_ns + poll_ns
            self.near_edge = check_ns < poll_at_ns + poll_ns // 2
            yield check_ns if check_ns < poll_at_ns else poll_at_ns
            if not self.serve() or self._next != index:
                return False
            if self._t_ns >= check_ns:
                break
        if ahead_ns:
            yield until_ns
        return self._next == index

    def _pulse(self, slot: int, due_ns: int, code: int) -> Generator[int, None, None]:
        step = code & STEP_BITS
        if not step:
            self._played()
            return
        try:
            before_ns = self._now()
            self._lines.write(step, step)
            up_ns = self._now()
            self._count(slot, due_ns, code, self._edge(before_ns, up_ns))
            yield up_ns + self._settings.pulse_width_ns
        finally:
            self._lines.write(0, step)
            self._fell_ns = self._now()

    def _edge(self, before_ns: int, after_ns: int) -> int:
        """When the edge was: as far before the end of its write as the quickest write takes.

        What every write costs cancels out of the gaps; a write that was held up counts late.
        """
        self._write_ns = min(self._write_ns, after_ns - before_ns)
        return after_ns - self._write_ns

    def _count(self, slot: int, due_ns: int, code: int, edge_ns: int) -> None:
        words, (first, second, third) = self._words, _DELTAS[code]
        words[b.VERSION] += 1
        self._fence()
        words[b.COUNTS] += first
        words[b.COUNTS + 1] += second
        words[b.COUNTS + 2] += third
        self._board.due_ns[slot] = edge_ns
        self._fence()
        words[b.VERSION] += 1
        if not self._fresh:
            self._last_gap_ns = due_ns - self._last_due_ns
        self._fresh = False
        self._last_due_ns, self._last_edge_ns = due_ns, edge_ns
        self._played()

    def _played(self) -> None:
        self._next += 1
        self._words[b.PLAYED] = self._next

    def _drop(self) -> None:
        """Empty the queue; a dropped tick steps no motor, so it is not taken for a sent one."""
        pushed = self._words[b.PUSHED]
        self._fence()
        for index in range(self._next, pushed):
            self._board.codes[index & b.SLOT_MASK] = 0
        self._fence()
        self._next = self._words[b.PLAYED] = pushed

    def _turned(self, code: int) -> int:
        """DIR levels for a tick; motors that do not step keep theirs."""
        stepping = code & STEP_BITS
        high = (~(code >> 3) ^ self._settings.inverted) & stepping
        return self._directions & ~(stepping << DIRECTION_SHIFT) | high << DIRECTION_SHIFT

    def _trip(self) -> int:
        """Reason code of the input that is not idle, or 0."""
        settings = self._settings
        wrong = (self._lines.read() ^ settings.input_idle) & settings.input_mask
        if not wrong:
            return b.NO_REASON
        if wrong & ESTOP_BIT:
            return b.BY_ESTOP
        alarms = wrong >> ALARM_SHIFT
        return b.BY_ALARM + (alarms if alarms == b.ALL_MOTORS else alarms.bit_length())

    def _silent(self) -> bool:
        return self._t_ns - self._words[b.BEAT] > self._settings.heartbeat_ns

    def _obey(self) -> None:
        words = self._words
        self._fence()
        action = {
            b.ENABLE: self._enable,
            b.DISABLE: self._disable,
            b.ACKNOWLEDGE: self._acknowledge,
            b.SET_COUNTS: self._set_counts,
            b.SWITCH: self._switch_asked,
        }[words[b.KIND]]
        words[b.RESULT] = action()
        self._fence()
        words[b.SERVED] = words[b.COMMAND]

    def _refusal(self) -> int:
        """Result code for inputs that forbid what was asked, or DONE."""
        trip = self._trip()
        if trip == b.BY_ESTOP:
            return b.ESTOP_OPEN
        return b.ALARM_ON + trip - b.BY_ALARM if trip else b.DONE

    def _enable(self) -> int:
        refusal = self._refusal()
        if refusal:
            return refusal
        if self._state == b.STOPPED:
            return b.IS_STOPPED
        self._energise(True)
        if self._state == b.DISABLED:
            self._enter(b.READY)
        return b.DONE

    def _disable(self) -> int:
        self._drop()
        self._switches_safe()
        self._energise(False)
        if self._state != b.STOPPED:
            self._enter(b.DISABLED)
        return b.DONE

    def _acknowledge(self) -> int:
        if self._state != b.STOPPED:
            return b.DONE
        refusal = self._refusal()
        if refusal:
            return refusal
        self._drop()
        self._words[b.REASON] = b.NO_REASON
        self._enter(b.DISABLED)
        return b.DONE

    def _set_counts(self) -> int:
        words = self._words
        if words[b.PUSHED] != self._next:
            return b.IS_MOVING
        words[b.VERSION] += 1
        self._fence()
        for motor in range(3):
            words[b.COUNTS + motor] = words[b.ARGUMENTS + motor]
        self._fence()
        words[b.VERSION] += 1
        return b.DONE

    def _switch_asked(self) -> int:
        if self._state == b.STOPPED:
            return b.IS_STOPPED
        if self._state == b.DISABLED:
            return b.IS_DISABLED
        levels, mask = self._words[b.ARGUMENTS], self._words[b.ARGUMENTS + 1]
        self._switch(levels, mask & self._settings.switch_mask)
        return b.DONE

    def _switch(self, levels: int, mask: int) -> None:
        if mask:
            self._lines.write(levels, mask)
            self._words[b.SWITCHED] = self._words[b.SWITCHED] & ~mask | levels & mask

    def _switches_safe(self, quiet: bool = False) -> None:
        """quiet: the lines have failed already, and what they say now is nothing new."""
        try:
            self._switch(self._settings.switch_safe, self._settings.switch_mask)
        except OSError:
            if not quiet:
                raise

    def _energise(self, on: bool) -> None:
        level = self._settings.enable_level if on else 1 - self._settings.enable_level
        self._lines.write(ENABLE_BIT * level, ENABLE_BIT)
        self._words[b.ENERGISED] = int(on)

    def _enter(self, state: int) -> None:
        self._state = self._words[b.STATE] = state
