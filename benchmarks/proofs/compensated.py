"""What compensation leaves where sizes are known: python -m benchmarks.proofs.compensated.

A MuJoCo robot with one cause or two draws the heart of `deltactl demo`, planned with exactly these
causes in its robot file, and with their sizes 3 % too large and too small. Printed: the distance
of the platform from its target, RMS [mm]; a healing aims at 0.15 or less.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.robot import EffectEntry
from deltactl.proof.hidden.vocabulary import SHAFT_NM_PER_RAD, VOCABULARY, Planned, construct
from deltactl.proof.recorded import Machine
from deltactl.repair.campaign import JOB, ROBOT
from deltactl.repair.machine import FaultyRobot
from deltactl.repair.played import played

SIZES = (1.0, 1.03, 0.97)
KNOWN_BY_SIZE = ("width", "time", "dead_time", "frequency", "damping")
"""What is off in a robot file whose sizes are off."""


class Cause(NamedTuple):
    """An effect on one component, with its sizes."""

    effect: str
    number: int
    sizes: dict[str, float]

    def entry(self, times: float) -> EffectEntry:
        """As in a robot file, with sizes so many times as large."""
        sizes = {
            name: size * (times if name in KNOWN_BY_SIZE else 1.0)
            for name, size in self.sizes.items()
        }
        component = VOCABULARY[self.effect].components[self.number]
        return EffectEntry(effect=self.effect, component=component, parameters={**sizes})

    def planned(self) -> Planned:
        """As a machine is built with it."""
        return Planned(VOCABULARY[self.effect], self.number, {**self.sizes})


def play(degrees: float, motor: int = 1, drag: float = 8.0) -> Cause:
    """Play in which an arm hangs."""
    sizes = {"width": math.radians(degrees), "friction": 0.2, "drag": drag}
    return Cause("gear_backlash", motor - 1, sizes)


def friction(degrees: float, motor: int = 1) -> Cause:
    """A shaft that is wound up, in which an arm sticks."""
    sizes = {"width": math.radians(degrees), "stiffness": SHAFT_NM_PER_RAD}
    return Cause("joint_friction", motor - 1, sizes)


def lag(time_s: float, motor: int = 2) -> Cause:
    """A drive that follows late."""
    return Cause("following_lag", motor - 1, {"time": time_s, "dead_time": 0.0})


def ringing(frequency_hz: float, damping: float = 0.1) -> Cause:
    """A platform that rings."""
    return Cause("resonance", 0, {"frequency": frequency_hz, "damping": damping})


def rows() -> dict[str, list[Cause]]:
    """Causes of each robot, by its name in the table."""
    return {
        "nothing": [],
        **{f"play {size}": [play(size)] for size in (0.2, 0.4, 0.6, 0.8)},
        **{
            f"play 0.6, motor {motor}, drag {drag:g}": [play(0.6, motor, drag)]
            for motor in (2, 3)
            for drag in (8.0, 12.0)
        },
        "play 0.4, drag 10": [play(0.4, 1, 10.0)],
        **{f"friction 0.45, motor {motor}": [friction(0.45, motor)] for motor in (1, 2)},
        **{f"lag {size}": [lag(size)] for size in (0.05, 0.1, 0.2)},
        **{f"ringing {size}": [ringing(size)] for size in (1.54, 2.5, 4.0, 6.0)},
        **{f"ringing 1.54, damping {size}": [ringing(1.54, size)] for size in (0.05, 0.2)},
        **{
            f"play 0.6, lag {size}, both of motor 1": [play(0.6), lag(size, 1)]
            for size in (0.1, 0.2)
        },
        "play 0.6, lag 0.1 of motor 2": [play(0.6), lag(0.1)],
        "play 0.6, lag 0.1, both of motor 2": [play(0.6, 2), lag(0.1)],
        "friction 0.45, lag 0.1, both of motor 2": [friction(0.45, 2), lag(0.1)],
        **{f"play 0.6, ringing {size}": [play(0.6), ringing(size)] for size in (1.54, 3.0)},
        **{
            f"play 0.6 of motor {motor}, ringing 1.54": [play(0.6, motor), ringing(1.54)]
            for motor in (2, 3)
        },
        **{
            f"friction 0.45 of motor 2, ringing {size}": [friction(0.45, 2), ringing(size)]
            for size in (1.54, 3.0)
        },
        **{f"lag 0.1, ringing {size}": [lag(0.1), ringing(size)] for size in (1.54, 3.0)},
        "lag 0.2, ringing 3.0": [lag(0.2), ringing(3.0)],
    }


def left_m(causes: Sequence[Cause], times: float = 1.0) -> float:
    """Distance from the target, RMS [m], with sizes so many times as large in the robot file."""
    machine = Machine()
    construct(machine, [cause.planned() for cause in causes], with_events=True)
    effects = tuple(cause.entry(times) for cause in causes)
    robot = load_robot(ROBOT).model_copy(update={"effects": effects})
    return FaultyRobot(machine, [], 0).draw(played(plan_of(JOB, robot))).rms_m


def main() -> None:
    """A line for each robot."""
    print(f"{'[degrees, s, Hz]':40s} exact  +3 %   -3 %")
    for says, causes in rows().items():
        print(f"{says:40s}", *(f"{1e3 * left_m(causes, times):.3f}" for times in SIZES), sep="  ")


if __name__ == "__main__":
    main()
