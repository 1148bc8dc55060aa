"""The simulated robot while nobody looks: a night with the drives off must cost no memory."""

from __future__ import annotations

import math
import tracemalloc
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.firmware_py.simulation.world import GRID_S, SimulatedRobot
from deltactl.foundation.clock import NS_PER_S, sleep_s
from deltactl.models.chain import OnlineChain, Outputs
from deltactl.models.robot import AXES, EffectEntry, FloatArray

PLAY = EffectEntry(effect="gear_backlash", component="motor1", parameters={"width": 0.02})
FEW_SECONDS_NS, UNWATCHED_NS = 3 * NS_PER_S, 40 * NS_PER_S
PLAY_BUILT = """
as_built:
  effects:
    - {effect: gear_backlash, component: motor1, parameters: {width: 0.02}}
"""
STEADY_BYTES = 2_000_000
"""Five seconds remembered, and a block on its way; all at once would be 3 MB, with play 14."""


@pytest.fixture(params=[(), (PLAY,)], ids=["nominal", "with play"])
def robot(request: pytest.FixtureRequest) -> RobotFile:
    nominal = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
    return nominal.model_copy(update={"effects": request.param})


class Swinging:
    """A world whose arms swing, and its time."""

    def __init__(self, robot: RobotFile):
        self.now_ns = 0
        self.world = SimulatedRobot(robot, self._counts_at, lambda: self.now_ns)

    def _counts_at(self, t_ns: int) -> tuple[float, float, float]:
        swing = round(400.0 * math.sin(t_ns / NS_PER_S))
        return 1000 + swing, 1000 - swing, 1000

    def look(self, now_ns: int) -> tuple[float, ...]:
        """What sensors see of the last 20 ms, and where the platform is."""
        self.now_ns = now_ns
        seen = [self.world.distance_m(axis, now_ns - 20_000_000, now_ns) for axis in AXES]
        return *seen, *self.world.truth(now_ns).position_m


def test_nobody_looking_changes_nothing(robot: RobotFile) -> None:
    watched, unwatched = Swinging(robot), Swinging(robot)
    end_ns = 4 * FEW_SECONDS_NS
    for now_ns in range(0, end_ns, NS_PER_S // 7):
        watched.look(now_ns)
    assert unwatched.look(end_ns) == pytest.approx(watched.look(end_ns), abs=1e-12)
    before_ns = end_ns - FEW_SECONDS_NS  # still remembered
    assert unwatched.world.truth(before_ns) == watched.world.truth(before_ns)


@pytest.mark.study
def test_nobody_looking_costs_no_memory(robot: RobotFile) -> None:
    swinging = Swinging(robot)
    swinging.look(FEW_SECONDS_NS)
    tracemalloc.start()
    try:
        swinging.look(UNWATCHED_NS)
        _, peak_bytes = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak_bytes < STEADY_BYTES


def test_a_night_is_not_worked_out_when_somebody_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A machine with effects remembers: an hour with the drives off is 1.8 million samples."""
    worked_out: list[int] = []
    advance = OnlineChain.advance

    def counted(chain: OnlineChain, t_s: FloatArray, counts: FloatArray) -> Outputs:
        worked_out.append(len(t_s))
        return advance(chain, t_s, counts)

    monkeypatch.setattr(OnlineChain, "advance", counted)
    built = tmp_path / "built.yaml"
    built.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text() + PLAY_BUILT)
    controller = build_controller(built, simulated=True, realtime=False, recordings=tmp_path)
    sleep_s(controller.clock, 10.0)
    worked_out.clear()
    controller.power_on()
    controller.close()
    assert sum(worked_out) * GRID_S < 2.0
