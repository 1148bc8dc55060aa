"""The chain block by block, as the simulated robot behind the fakes needs it."""

from __future__ import annotations

from collections.abc import Iterable

from deltactl.models.chain.active import Active, of_entries
from deltactl.models.chain.commands import Commands
from deltactl.models.chain.delta import Chain
from deltactl.models.chain.outputs import Outputs
from deltactl.models.robot import DeltaRobot, EffectEntry, FloatArray


class OnlineChain:
    """Carries the operators' state from block to block: same result as one whole call."""

    def __init__(self, robot: DeltaRobot, effects: Iterable[EffectEntry] = ()):
        self._chain = Chain(robot.model_copy(update={"effects": ()}))
        self._effects: list[Active] = of_entries([*robot.effects, *effects])
        self._start_s: float | None = None
        self._previous_s = 0.0

    def advance(self, t_s: FloatArray, counts: FloatArray) -> Outputs:
        """Go on with samples at `t_s` (n,) and commanded counts (n, 3) there.

        Times must go on increasing from call to call. Raises ValueError without a drive section.
        """
        drive = self._chain.robot.drive
        if drive is None:
            raise ValueError("the robot file needs a drive section to turn counts into angles")
        commands = Commands.of_counts(t_s, counts, drive)
        if self._start_s is None:
            self._start_s = float(commands.t_s[0])
            outputs = self._chain.simulate(commands, self._effects, self._start_s)
        else:
            commands.fresh[0] = False
            outputs = self._chain.simulate(commands, self._effects, self._start_s, self._previous_s)
        self._previous_s = float(commands.t_s[-1])
        return outputs
