"""An axis that follows commands, stepper or servo: what it read, and what may differ.

prediction = gear(play(lag(command))) + sum of shapes: a constant, a ratio, a droop under known
load, errors that repeat with the angle, slow drifts. Odds and spreads stand at each regressor,
with their source.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from diagnosis.observations.needed_columns import (
    filled,
    first_of,
    needed,
    refuse_other_units,
    refuse_still,
)
from diagnosis.observations.readings import FloatArray, IntArray, Readings, gather, step_of
from diagnosis.plants.regression import Columns, Equivalent, Regressor, Shown, Size, Sizes
from diagnosis.plants.spline_terms import KeepsBeside, spline_terms
from models.chain.axis import AxisChain
from models.chain.commands import Commands
from models.effects.axis_play import loose
from models.effects.recursion import delayed, lagged, linear
from models.robot import ServoAxis, StepperAxis
from recording.flat import FlatRecording

OBSERVED = ("theta_1", "position")
COMMANDED = ("command_1", "command")
FEWEST = 40
MOST_ROWS = 2000
"""Rows beyond which an axis tells no more: readings are correlated over many samples."""
MOST_SAMPLES = 4000
MOVING = 0.05
"""Share of the top speed above which a row counts as in motion."""
PIECES = 6
LAGS_S = (
    (0.0, 0.02), (0.0, 0.08), (0.03, 0.0), (0.1, 0.0), (0.06, 0.06), (0.25, 0.05), (0.06, 0.25),
)  # fmt: skip
"""Time constants and dead times to start from."""
WIDTHS = (0.05, 0.15, 0.4, 1.0)
"""Widths of play to start from, as shares of how far reading and prediction are apart."""
SIDES = (-0.7, 0.0, 0.7)
STAGES = ("lag", "ringing", "friction", "play")
"""Parts of the chain from the command to the axis, in their order."""
MOST_KEPT = 128
MOST_BEGINS = 4
"""Stretches whose side of the play at the start is fitted; later ones begin in its middle."""
COARSEST_STEPS = 4.0
"""Steps of the reading in the shortest wave: rounding itself repeats with every step."""
FULL_STEPS = 200.0
"""Of a turn of the usual stepper motor (1.8 degrees each)."""
MOST_WAVES = 60.0
FEWEST_WAVES = 2.0
PERIODS = 3
SAME = 0.999
"""Correlation of two covariates above which they are one: an axis that turns steadily."""
FREE_SPREAD = 1e3
RATIO_SPREAD = {"stepper_axis": 0.02, "servo_axis": 0.01}
"""A servo closes its loop over what is read: only another encoder sees another ratio."""
WIDEST_PLAY = 0.6
LAG_SPREAD_S = 0.1
"""A drive's lag is tens of milliseconds; a hobby servo's a tenth of a second (SO-101, STS3250)."""


class CommandedAxis(KeepsBeside):
    """A lone axis by its commands."""

    def __init__(self, robot: StepperAxis | ServoAxis, recordings: Sequence[FlatRecording]):
        self.robot = robot
        servo = isinstance(robot, ServoAxis)
        self.unit = "m" if isinstance(robot, ServoAxis) and robot.motion == "linear" else "rad"
        self.rad_per_step = robot.drive.rad_per_step if isinstance(robot, StepperAxis) else 0.0
        self.chain = self._chain()
        recordings = [_thinned(recording) for recording in recordings]
        order = OBSERVED[::-1] if servo else OBSERVED
        self.name = needed(recordings[0], order, "position" if servo else "theta_1")
        self.readings: Readings = gather(recordings, [self.name], {self.name: self.unit}, FEWEST)
        self.observed = np.nan_to_num(self.readings.values[:, 0])
        self.t_s = self.readings.t_s
        self.commanded = np.concatenate([self._commanded(r) for r in recordings])
        source = recordings[0].source
        refuse_still(self.commanded, "the command", source)
        refuse_still(self.readings.values[:, 0], self.name, source)
        refuse_other_units(
            self.commanded, self.readings.values[:, 0], f"{self.name} and the command", source
        )
        self._commands = [
            Commands.of_angles(self.t_s[p], self.commanded[p, None], self.readings.fresh[p])
            for p in self._parts
        ]
        self.pull = self._pull(recordings)
        self.nominal = np.concatenate(
            [
                self.chain.simulate(c, (), self.pull[p, None])
                for c, p in zip(self._commands, self._parts, strict=True)
            ]
        )
        self.drawn_on = np.zeros(len(self.t_s))
        self.resolution = step_of(self.readings.values[:, 0])
        """Smallest step of the reading: no play below it can be told from rounding."""
        self.rounding = self.resolution / float(np.sqrt(12.0))
        self.rows = self._rows()
        self.groups = np.cumsum(self.readings.fresh).astype(np.intp)
        self.kinds = self._moving()
        self.beside = np.zeros((len(self.t_s), 0))
        self._kept: dict[tuple[object, ...], FloatArray] = {}
        self.regressors = tuple(self._regressors())

    # ---- the recording -------------------------------------------------------------------------

    def _chain(self) -> AxisChain:
        robot = self.robot
        if isinstance(robot, StepperAxis):
            return AxisChain("rotary", None, None, robot.drive.rad_per_step, robot.effects)
        return AxisChain(robot.motion, robot.gravity, robot.drive_stiffness, 0.0, robot.effects)

    def _commanded(self, recording: FlatRecording) -> FloatArray:
        servo = isinstance(self.robot, ServoAxis)
        name = first_of(recording, COMMANDED[::-1] if servo else COMMANDED)
        if name is not None:
            return filled(recording, name)
        if isinstance(self.robot, StepperAxis) and first_of(recording, ["steps_1"]):
            return filled(recording, "steps_1") * self.rad_per_step
        needed(recording, (), "command" if servo else "command_1")
        raise AssertionError("needed() raises")

    @cached_property
    def _parts(self) -> list[FloatArray]:
        part = self.readings.part
        return [part == n for n in range(int(part[-1]) + 1)]

    def _pull(self, recordings: Sequence[FlatRecording]) -> FloatArray:
        """Known load on the axis (n,): gravity where the axis is, and what a column gives."""
        at = np.where(self.readings.valid[:, 0], self.observed, self.commanded)
        loads = [
            filled(r, "load") if first_of(r, ["load"]) else np.zeros(len(r)) for r in recordings
        ]
        gravity = self.robot.gravity if isinstance(self.robot, ServoAxis) else None
        load: FloatArray = np.concatenate(loads)
        if gravity is not None:
            load = load - gravity.torque_nm * np.sin(at - gravity.zero_rad)
        return load

    def _rows(self) -> IntArray:
        valid = np.flatnonzero(self.readings.valid[:, 0])
        stride = max(1, -(-len(valid) // MOST_ROWS))
        return valid[::stride]

    def _moving(self) -> IntArray:
        """1 while the command moves or has just moved: there a drive does what no model follows."""
        step_s = np.maximum(np.diff(self.t_s, prepend=self.t_s[0] - 1.0), 1e-9)
        speed = np.abs(np.diff(self.commanded, prepend=self.commanded[0])) / step_s
        # How a stretch began nobody knows: what the axis was doing counts as motion.
        speed[self.readings.fresh] = float(np.max(speed[~self.readings.fresh], initial=0.0))
        late = lagged(
            speed[:, None], np.where(self.readings.fresh, 0.0, step_s), 3 * LAG_SPREAD_S, {}
        )
        moving: IntArray = (late[:, 0] > MOVING * np.quantile(late, 0.98)).astype(np.intp)
        share = float(moving[self.rows].mean())
        return moving if 0.1 < share < 0.9 else np.zeros_like(moving)

    # ---- what may differ -----------------------------------------------------------------------

    @cached_property
    def span(self) -> float:
        """Travel of the command."""
        return float(np.ptp(self.commanded[self.rows]))

    @cached_property
    def mismatch(self) -> float:
        """How far reading and nominal prediction are apart: the spread of shapes of any size."""
        left = (self.observed - self.nominal)[self.rows]
        left = left - np.median(left) if self.robot.zero == "arbitrary" else left
        return max(float(np.sqrt(np.mean(np.clip(left**2, 0.0, np.quantile(left**2, 0.99))))),
                   1e-12 * max(self.span, 1e-12))  # fmt: skip

    def _regressors(self) -> list[Regressor]:
        lag = (
            Size("time", "half", LAG_SPREAD_S, 0.0, 2.0, 1e-3),
            Size("dead_time", "half", LAG_SPREAD_S, 0.0, 2.0, 1e-3),
        )
        width = Size("width", "half", max(2.0 * self.mismatch, 0.02 * self.span),
                     0.0, WIDEST_PLAY * self.span, 0.01 * self.mismatch)  # fmt: skip
        starts = tuple(Size(name, "flat", 1.0, -1.0, 1.0, 0.05) for name in self._begins)
        late = (
            Equivalent("sensor_latency", -1.0, only_if_zero="time"),
            Equivalent("viscous_friction", -1.5, only_if_zero="dead_time"),
        )
        known_pull = bool(np.ptp(self.pull[self.rows]) > 0.0)
        stepper = isinstance(self.robot, StepperAxis)
        found = [
            Regressor("ratio", "gear_ratio", -2.0 if stepper else -3.0),
            Regressor("lag", "following_lag", -1.0, sizes=lag, equivalents=late),
        ]
        if self.robot.zero == "absolute":
            yields = () if known_pull else (Equivalent("joint_compliance", -1.5),)
            found.append(Regressor("offset", "home_offset", -1.0, equivalents=yields))
        if known_pull:
            found += [
                Regressor("droop", "joint_compliance", -1.0),
                Regressor("play", "gear_backlash", -1.0, sizes=(width, *starts)),
                Regressor("friction", "joint_friction", -1.0, sizes=(width, *starts)),
            ]
        else:
            # Tooth play is what a geared stepper has, stiction what a servo's loop leaves.
            names = ("gear_backlash", "joint_friction")
            first, second = names if stepper else names[::-1]
            equivalent = Equivalent(second, -1.4 if stepper else -0.2)
            found.append(
                Regressor("play", first, -1.0, sizes=(width, *starts), equivalents=(equivalent,))
            )
        places = (self._gear(), self._jump(), self._ringing())
        found += [one for one in places if one is not None]
        found.append(Regressor("drift", "unknown", -4.0, follows=("time",), alone=False))
        found += [
            Regressor(f"unknown {name}", "unknown", -5.0, follows=(name,), left_over=True)
            for name in self.covariates
        ]
        return found

    def _gear(self) -> Regressor | None:
        waves = Size("waves", "flat", MOST_WAVES, FEWEST_WAVES, self._most_waves, 0.01)
        if self._most_waves <= 2.0 * FEWEST_WAVES:
            return None
        return Regressor(
            "gear", "transmission_error", -3.0, sizes=(waves,),
            equivalents=(Equivalent("encoder_error", -1.0),), alone=False,
        )  # fmt: skip

    @cached_property
    def _most_waves(self) -> float:
        """Waves over the travel that samples can follow: two a wave at the usual speed."""
        pace = float(np.median(np.abs(np.diff(self.commanded[self.rows]))))
        finest = max(2.0 * pace, COARSEST_STEPS * self.resolution, 1e-300)
        return min(MOST_WAVES, self.span / finest)

    def _jump(self) -> Regressor | None:
        if not self.rad_per_step:
            return None
        choices = max(float(self.readings.span_s), 4.0)
        moment = Size("moment", "flat", self.readings.span_s, float(self.t_s[0]),
                      float(self.t_s[-1]), 1.0, smooth=False, choices=choices)  # fmt: skip
        return Regressor("jump", "lost_steps", -6.0, sizes=(moment,), alone=False)  # fmt: skip

    def _ringing(self) -> Regressor | None:
        fastest = 0.2 / self.readings.period_s
        if fastest < 1.0:
            return None
        frequency = Size("frequency", "flat", fastest, 0.4, min(fastest, 25.0), 0.01)
        damping = Size("damping", "flat", 1.0, 0.01, 0.9, 0.01)
        return Regressor("ringing", "resonance", -4.0, sizes=(frequency, damping),
                         alone=False, saturated=False)  # fmt: skip

    # ---- prediction ----------------------------------------------------------------------------

    @cached_property
    def _step_s(self) -> FloatArray:
        steps = np.diff(self.t_s, prepend=self.t_s[0])
        steps[self.readings.fresh] = 0.0
        return steps

    @cached_property
    def _stretch_start_s(self) -> FloatArray:
        starts = self.t_s[self.readings.fresh]
        began: FloatArray = starts[np.cumsum(self.readings.fresh) - 1]
        return began

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Command behind lag and play, (n,)."""
        stages = [key for key in STAGES if key in keys]
        at = [f"{key}.{size.name}" for key in stages for size in self._sizes[key]]
        known = tuple((name, sizes[name]) for name in at if name in sizes)
        return self._behind(tuple(stages), known)

    def _behind(self, stages: tuple[str, ...], at: tuple[tuple[str, float], ...]) -> FloatArray:
        """The same, kept for the fits that pass here again: most move one size at a time."""
        if not stages:
            return self.nominal
        if (stages, at) not in self._kept:
            last = stages[-1]
            earlier = tuple((n, value) for n, value in at if not n.startswith(f"{last}."))
            driven = self._stage(last, self._behind(stages[:-1], earlier), dict(at))
            if len(self._kept) >= MOST_KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[stages, at] = driven
        return self._kept[stages, at]

    def _stage(self, key: str, driven: FloatArray, sizes: Sizes) -> FloatArray:
        """What one part of the chain makes of its input, (n,)."""
        if key == "lag":
            part = driven[:, None]
            part = delayed(part, self.t_s, self._stretch_start_s, sizes["lag.dead_time"], {})
            late: FloatArray = lagged(part, self._step_s, sizes["lag.time"], {})[:, 0]
            return late
        if key == "ringing":
            return self._rung(driven, sizes["ringing.frequency"], sizes["ringing.damping"])
        pull = self.pull if key == "play" else np.zeros(len(driven))
        return self._played(driven, sizes, key, pull)

    @cached_property
    def _sizes(self) -> dict[str, tuple[Size, ...]]:
        return {r.key: r.sizes for r in self.regressors}

    @cached_property
    def _begins(self) -> list[str]:
        """Sizes that say where in the play the first stretches begin."""
        count = min(int(np.count_nonzero(self.readings.fresh)), MOST_BEGINS)
        return ["start", *(f"start_{n}" for n in range(2, count + 1))]

    def _played(self, driven: FloatArray, sizes: Sizes, key: str, pull: FloatArray) -> FloatArray:
        starts = np.zeros(int(np.count_nonzero(self.readings.fresh)))
        known = [sizes[f"{key}.{name}"] for name in self._begins if f"{key}.{name}" in sizes]
        starts[: len(known)] = known[: len(starts)]
        width = sizes[f"{key}.width"]
        return loose(driven, self.readings.fresh, width, starts, pull, float(driven[0]))

    def _rung(self, driven: FloatArray, frequency_hz: float, damping: float) -> FloatArray:
        """A mass on a damped spring whose damper moves along: see models.effects.resonance."""
        omega = 2.0 * np.pi * frequency_hz
        pole = omega * complex(-damping, np.sqrt(1.0 - damping**2))
        share = 1.0 + 1j * damping / np.sqrt(1.0 - damping**2)
        step = self._step_s
        decay = np.exp(pole * step)
        kept = np.where(step > 0.0, (decay - 1.0) / (pole * np.maximum(step, 1e-12)), 0.0)
        part = driven[:, None]
        moved = np.diff(part, axis=0, prepend=part[:1])
        moved[step <= 0.0] = 0.0
        gain = np.where(step > 0.0, decay, 0.0)
        state = linear(gain, -(share * kept)[:, None] * moved, np.zeros(1, complex))
        rung: FloatArray = (part + state.real)[:, 0]
        return rung

    # ---- shapes --------------------------------------------------------------------------------

    def free(self) -> Columns:
        """The constant between command and reading where the zero is arbitrary: one a recording."""
        if self.robot.zero == "absolute":
            return Columns(np.zeros((len(self.t_s), 0)), np.zeros(0))
        shapes = np.stack([p.astype(float) for p in self._parts], axis=1)
        return Columns(shapes, np.full(shapes.shape[1], FREE_SPREAD * self.mismatch))

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Shapes of one regressor around a base."""
        if key == "offset":
            return Columns(np.ones((len(base), 1)), np.array([self.mismatch]), ("angle",))
        if key == "ratio":
            shape = base if self.robot.zero == "absolute" else base - np.mean(base[self.rows])
            return Columns(shape[:, None], np.array([RATIO_SPREAD[self.robot.kind]]), ("scale",))
        if key == "droop":
            return Columns(self.pull[:, None], np.array([self._yielding]), ("1/stiffness",))
        if key == "gear":
            return self._waves(base, sizes["gear.waves"])
        if key == "drift":
            return self._bend
        if key == "jump":
            after = (self.t_s >= sizes["jump.moment"]).astype(float)[:, None]
            return Columns(after, np.array([self.mismatch]), ("shift",))
        if key.startswith("unknown "):
            return self._unknown[key[len("unknown ") :]]
        return Columns(np.zeros((len(base), 0)), np.zeros(0))

    @cached_property
    def _bend(self) -> Columns:
        """A drift that bends slowly: second and third power of time, less a constant and a line."""
        scaled = (self.t_s - self.t_s.mean()) / max(float(np.ptp(self.t_s)), 1e-300)
        line = np.stack([np.ones_like(scaled), scaled], axis=1)
        bent = np.stack([scaled**2, scaled**3], axis=1)
        share, *_ = np.linalg.lstsq(line[self.rows], bent[self.rows], rcond=None)
        shapes = bent - line @ share
        return Columns(shapes / np.std(shapes, axis=0), np.full(2, self.mismatch))

    @cached_property
    def _yielding(self) -> float:
        pull = self.pull[self.rows]
        return 2.0 * self.mismatch / max(float(np.std(pull)), 1e-300)

    def _waves(self, base: FloatArray, waves: float) -> Columns:
        """First and second harmonic of a wave that repeats `waves` times over the travel."""
        angle = 2.0 * np.pi * waves / self.span * base
        shapes = np.stack(
            [np.sin(angle), np.cos(angle), np.sin(2 * angle), np.cos(2 * angle)], axis=1
        )
        spread = self.mismatch * np.array([1.0, 1.0, 0.5, 0.5])
        return Columns(shapes, spread, ("sine", "cosine", "sine2", "cosine2"))

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What a mismatch may follow, name -> (n,)."""
        velocity = np.gradient(self.commanded, self.t_s)
        found = {"position": self.commanded, "time": self.t_s, "velocity": velocity}
        chosen = self.commanded[self.rows], self.t_s[self.rows]
        if abs(float(np.corrcoef(*chosen)[0, 1])) > SAME:
            del found["time"]
        if np.ptp(self.pull[self.rows]) > 0.0:
            found["load"] = self.pull
        return found

    @cached_property
    def _spanned(self) -> FloatArray:
        """Named shapes that no spline term may take the place of, (n, j)."""
        named = [np.ones_like(self.t_s), self.commanded, self._lateness]
        if np.ptp(self.pull[self.rows]) > 0.0:
            named.append(self.pull)
        return np.stack(named, axis=1)

    @cached_property
    def _unknown(self) -> dict[str, Columns]:
        found = {}
        for name, values in self.covariates.items():
            pieces = PIECES if name != "time" else 2 * PIECES
            shapes = spline_terms(values, pieces, self._beside(name), self.rows)
            found[name] = Columns(shapes, np.full(shapes.shape[1], 0.5 * self.mismatch))
        return found

    def _beside(self, name: str) -> FloatArray:
        named = self._spanned[:, :2] if name == "time" else self._spanned
        return np.concatenate([named, self.beside], axis=1)

    def followed(self, key: str) -> FloatArray:
        """Covariate (n,) of an unknown."""
        return self.covariates[key[len("unknown ") :]]

    def variant(self) -> None:
        """There is one way to prepare it."""

    def adopt(self, trained: CommandedAxis) -> None:
        """Travel and spread of the recording that sizes were found on."""
        self.span, self.mismatch = trained.span, trained.mismatch

    @cached_property
    def _lateness(self) -> FloatArray:
        """What a small lag looks like: the command's own speed."""
        lateness: FloatArray = -np.gradient(self.commanded, self.t_s)
        return lateness

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the contract's effects, in the axis' own unit."""
        unit = self.unit
        stiffness = "N/m" if unit == "m" else "N m/rad"
        lost = max(self.rad_per_step, 1e-300)
        table = {
            "offset": [Shown("angle", unit, lambda v: v["angle"])],
            "ratio": [Shown("scale", "1", lambda v: 1.0 + v["scale"], nothing=1.0)],
            "lag": [
                Shown("time", "s", lambda v: v["time"]),
                Shown("dead_time", "s", lambda v: v["dead_time"]),
            ],
            "droop": [Shown("stiffness", stiffness, lambda v: 1.0 / v["1/stiffness"])],
            "gear": [
                Shown("amplitude", unit, lambda v: np.hypot(v["sine"], v["cosine"])),
                Shown("period", unit, lambda v: self.span / v["waves"]),
                Shown("phase", "rad", lambda v: np.arctan2(v["cosine"], v["sine"])),
            ],
            "jump": [Shown("steps", "microsteps", lambda v: -v["shift"] / lost),
                     Shown("time", "s", lambda v: v["moment"])],
            "ringing": [
                Shown("frequency", "Hz", lambda v: v["frequency"]),
                Shown("damping", "1", lambda v: v["damping"]),
            ],
        }  # fmt: skip
        width = [Shown("width", unit, lambda v: v["width"])]
        return {**table, "play": width, "friction": width}.get(key, [])

    @property
    def _full_step(self) -> float:
        """Least that a motor loses at the axis [rad]: one of its 200 full steps a turn."""
        if not isinstance(self.robot, StepperAxis):
            return 0.0
        return self.rad_per_step * self.robot.drive.microsteps_per_rev / FULL_STEPS

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """A spring that pushes, sizes at their bounds, play below a step of the reading."""
        if "droop" in keys and linear["droop"][0] <= 0.0:
            return True
        for key in keys & {"play", "friction"}:
            width = sizes[f"{key}.width"]
            if not self.resolution < width < 0.99 * WIDEST_PLAY * self.span:
                return True
        if "gear" in keys:
            waves = sizes["gear.waves"]
            if not 1.01 * FEWEST_WAVES < waves < 0.99 * self._most_waves:
                return True
        if "lag" in keys and sizes["lag.time"] + sizes["lag.dead_time"] > 1.9:
            return True
        if "jump" in keys and abs(float(linear["jump"][0])) < self._full_step:
            return True
        return "ringing" in keys and not 0.011 < sizes["ringing.damping"] < 0.89

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Where to start the nonlinear sizes of a regressor."""
        if key == "lag":
            return [{"lag.time": a, "lag.dead_time": b} for a, b in LAGS_S]
        if key in ("play", "friction"):
            apart = float(np.ptp(np.quantile(residual[self.rows], [0.02, 0.98])))
            return [
                {
                    f"{key}.width": min(share * apart, 0.5 * self.span),
                    **{f"{key}.{name}": side for name in self._begins},
                }
                for share in WIDTHS
                for side in SIDES
            ]
        if key == "gear":
            return [{"gear.waves": w} for w in self._likely_waves(residual)]
        if key == "jump":
            return [{"jump.moment": self._likely_jump(residual)}]
        if key == "ringing":
            top = next(r for r in self.regressors if r.key == "ringing").sizes[0].high
            near = np.geomspace(0.6, 0.9 * top, 7)
            return [{"ringing.frequency": float(f), "ringing.damping": 0.1} for f in near]
        return [{}]

    def _likely_waves(self, residual: FloatArray) -> list[float]:
        """Peaks of the residual's spectrum over the travel, slow changes and a line taken off."""
        rows = self.rows[:: max(1, len(self.rows) // 800)]
        left, at = residual[rows], self.commanded[rows] / self.span
        time = (self.t_s[rows] - self.t_s[rows].mean()) / max(self.readings.span_s, 1e-300)
        slow = np.stack([np.ones_like(at), at, time, time**2], axis=1)
        left = left - slow @ np.linalg.lstsq(slow, left, rcond=None)[0]
        waves = np.linspace(1.1 * FEWEST_WAVES, self._most_waves, int(6 * self._most_waves))
        turns = np.exp(2j * np.pi * np.outer(at, waves))
        power = np.abs(left @ turns) ** 2
        best: list[float] = []
        for number in np.argsort(-power):
            if all(abs(waves[number] - other) > 0.6 for other in best):
                best.append(float(waves[number]))
            if len(best) == PERIODS:
                break
        return best

    def _likely_jump(self, residual: FloatArray) -> float:
        """Moment from which on the residual stands elsewhere, by the largest likelihood ratio."""
        left = residual[self.rows]
        left = left - left.mean()
        sums = np.cumsum(left)[:-1]
        count = np.arange(1, len(left))
        gain = sums**2 / (count * (len(left) - count))
        edge = max(4, len(left) // 200)
        gain[:edge] = gain[-edge:] = 0.0
        return float(self.t_s[self.rows[int(np.argmax(gain)) + 1]])


def _thinned(recording: FlatRecording) -> FlatRecording:
    """Every so many rows of a long recording: an axis hardly moves between them."""
    stride = -(-len(recording) // MOST_SAMPLES)
    if stride == 1:
        return recording
    columns = {name: values[::stride] for name, values in recording.columns.items()}
    return FlatRecording(recording.t_s[::stride], columns, {}, recording.source)
