"""A checked job as instructions: moves with their plans, outputs, waits, and what is repeated.

A job with one path is a program of one move. Between two moves the arms rest; the way from the
end of one to the beginning of the next is looked for, and checked, before anything moves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.planner.plan import Plan
from deltactl.firmware_py.robot_file import RobotFile


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Go to where a path starts, and follow it."""

    plan: Plan


@dataclass(frozen=True, slots=True)
class SetOutputs:
    """Switch outputs."""

    on: dict[str, bool]

    def says(self) -> str:
        """In words."""
        return ", ".join(f"{name} {'on' if on else 'off'}" for name, on in self.on.items())


@dataclass(frozen=True, slots=True)
class Wait:
    """Rest for so long."""

    seconds: float


@dataclass(frozen=True, slots=True)
class WaitFor:
    """Rest until an input is as asked; give up after `within_s`."""

    input: str
    is_on: bool
    within_s: float

    def says(self) -> str:
        """In words."""
        return f"{self.input} to be {'on' if self.is_on else 'off'}"


@dataclass(frozen=True, slots=True)
class Pause:
    """Rest until somebody sends `resume`."""

    why: str


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Instructions, so many times."""

    count: int
    steps: tuple[Instruction, ...]

    def leaves(self) -> Iterator[Leaf]:
        """One instruction after another, as they are carried out."""
        for _ in range(self.count):
            for one in self.steps:
                if isinstance(one, Block):
                    yield from one.leaves()
                else:
                    yield one


Leaf = Move | SetOutputs | Wait | WaitFor | Pause
Instruction = Leaf | Block


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """A job that may run."""

    job: JobFile
    robot: RobotFile
    whole: Block

    def leaves(self) -> Iterator[Leaf]:
        """What the job does, one thing after another."""
        return self.whole.leaves()

    def plans(self) -> Iterator[Plan]:
        """The plans of its moves, each once."""
        seen: set[int] = set()
        for plan in _plans(self.whole):
            if id(plan) not in seen:
                seen.add(id(plan))
                yield plan

    @property
    def first(self) -> Plan | None:
        """The plan of the first move."""
        return next(_plans(self.whole), None)


def _plans(block: Block) -> Iterator[Plan]:
    for one in block.steps:
        if isinstance(one, Move):
            yield one.plan
        elif isinstance(one, Block):
            yield from _plans(one)


Visit = Callable[[Leaf, Counts, int], None]
"""Called for each instruction: the arms before it, and how often it comes in this state."""


def visit(block: Block, counts: Counts, tell: Visit, times: int = 1) -> Counts:
    """Go through a block once for its first time round and once for all others.

    The arms come to a repeat from elsewhere only the first time. Returns where they end.
    """
    rounds = [1] if block.count == 1 else [1, block.count - 1]
    for together in rounds:
        for one in block.steps:
            if isinstance(one, Block):
                counts = visit(one, counts, tell, times * together)
                continue
            tell(one, counts, times * together)
            if isinstance(one, Move):
                counts = one.plan.last_counts
    return counts
