"""Put a machine together: which one, how it moves, how it is read, and its file."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import savgol_filter

from deltactl.proof.axis.catalogue import Scale
from deltactl.proof.axis.commanded import CommandedAxis, Sizes
from deltactl.proof.axis.forced import ForcedAxis, neighbour
from deltactl.proof.axis.motions import ONE_WAY, STYLES, FloatArray, Motion, Pace, move
from deltactl.proof.axis.observer import Observer
from deltactl.proof.axis.sensing import Mess, Noise, RangeSensor, Rows

RATES_HZ = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
LENGTHS_S = (20.0, 30.0, 60.0, 120.0, 300.0, 900.0, 3600.0)
ROWS = (400.0, 18000.0)
FORCED_RATES_HZ, FORCED_LENGTHS_S = RATES_HZ[3:], LENGTHS_S[:5]
GRID = {"commanded": (120_000, 0.25), "effort": (90_000, 0.5), "range": (60_000, 0.5)}
"""Most steps of a simulation, which keep a case to about a second; the longest, in rows."""
HOLDOUT_SHARE = 0.6


@dataclass(frozen=True)
class Design:
    """What is drawn of a machine before anything is hidden in it."""

    machine: str
    style: str
    pace: Pace
    rate_hz: float
    mess: Mess
    noise: Noise
    """Noise of the position or the range."""
    effort_noise: Noise
    linear: bool
    counted: bool
    """A stepper axis, commanded in microsteps."""
    step_size: float
    names: str
    absolute: bool
    inertia: float
    gain: float
    gravity: tuple[float, float]
    weight: float
    states_gravity: bool
    loaded: bool
    speed_column: bool


def design(
    machine: str, rng: np.random.Generator, fine: bool = False, style: str | None = None
) -> Design:
    """Draw one. fine: readings so good that something gross is a hundred times their noise."""
    rate, seconds = _rate_and_length(machine, rng)
    low, high = max(15.0 / rate, 0.3, seconds / 400.0), min(seconds / 8.0, 40.0)
    stroke_s = _between(rng, low, max(high, low))
    linear = bool(rng.random() < 0.4)
    stroke = _between(rng, 0.02, 1.0) if linear else _between(rng, 0.2, 6.0)
    if machine == "range":
        linear, stroke = True, _between(rng, 0.3, 6.0)
    steps, longest = GRID[machine]
    step_s = max(min(longest / rate, stroke_s / 400.0), seconds / steps)
    noise = _noise(machine, stroke, rng, fine)
    inertia = _between(rng, 0.3, 60.0) if linear else _between(rng, 1e-3, 2.0)
    force = inertia * stroke / stroke_s**2
    falls = force * _between(rng, 0.5, 10.0)
    weighs = bool(rng.random() < 0.45)
    counted = machine == "commanded" and bool(rng.random() < 0.4)
    return Design(
        machine=machine,
        style=style or str(rng.choice(sorted(STYLES))),
        pace=Pace(seconds, step_s, stroke, stroke_s, endless=not linear),
        rate_hz=rate,
        mess=_mess(machine, rng, rate),
        noise=noise,
        effort_noise=Noise(
            force * 10.0 ** float(rng.uniform(-2.5, -1.5 if fine else -0.7)),
            float(rng.choice([0.0, 0.0, 0.4])),
            noise.outliers,
            0.0,
        ),
        linear=linear and not counted,
        counted=counted,
        step_size=_microstep(stroke, rng) if counted else 0.0,
        names=str(rng.choice(["position", "theta_1"])) if not linear else "position",
        absolute=bool(rng.random() < 0.5),
        inertia=inertia,
        gain=float(rng.choice([1.0, round(float(np.exp(rng.uniform(-3.0, 3.0))), 4)])),
        gravity=(falls, float(rng.uniform(-1.5, 1.5))) if weighs and not linear else (0.0, 0.0),
        weight=falls if weighs and linear else 0.0,
        states_gravity=weighs or bool(rng.random() < 0.7),
        loaded=bool(rng.random() < 0.2),
        speed_column=bool(rng.random() < 0.3),
    )


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw one whose logarithm is uniform."""
    return float(np.exp(rng.uniform(*np.log([low, high]))))


def _rate_and_length(machine: str, rng: np.random.Generator) -> tuple[float, float]:
    forced = machine == "effort"
    rates, lengths = (FORCED_RATES_HZ, FORCED_LENGTHS_S) if forced else (RATES_HZ, LENGTHS_S)
    while True:
        rate, seconds = float(rng.choice(rates)), float(rng.choice(lengths))
        if ROWS[0] <= rate * seconds <= ROWS[1]:
            return rate, seconds


def _noise(machine: str, stroke: float, rng: np.random.Generator, fine: bool) -> Noise:
    size = 10.0 ** rng.uniform(-4.3, -3.3 if fine else -2.3)
    if machine == "effort":
        size = 10.0 ** rng.uniform(-5.5, -4.0)
    sigma = stroke * size
    return Noise(
        sigma,
        float(rng.choice([0.0, 0.0, 0.3, 0.6, 0.85])),
        float(rng.choice([0.0, 0.0, 0.002, 0.006])),
        float(rng.choice([0.0, 1.0, 2.5])) * sigma,
    )


def _microstep(stroke: float, rng: np.random.Generator) -> float:
    """Step of a usual motor and a gear whose microsteps are fine for the stroke."""
    gear = max(round(10.0 * np.pi / stroke), 5)
    return 2.0 * np.pi / (3200.0 * gear * float(rng.choice([1, 2, 5])))


def _mess(machine: str, rng: np.random.Generator, rate_hz: float) -> Mess:
    """A held position would be an acceleration that hides all efforts: none of those."""
    tidy = rng.random() < 0.3
    if tidy:
        return Mess()
    return Mess(
        jitter=float(rng.choice([0.0, 0.1, 0.4])),
        stamp=float(rng.choice([0.0, 0.0, 0.1])),
        drop=float(rng.choice([0.0, 0.01, 0.04])),
        gaps=int(rng.choice([0, 0, 1, 2])),
        held=float(rng.choice([0.0, 0.0, 0.0, 0.01])) if machine != "effort" else 0.0,
        clock_s=float(rng.choice([0.0, 0.0, 0.001])) if rate_hz <= 200.0 else 0.0,
    )


@dataclass(frozen=True)
class Run:
    """A machine in one motion, before it is known what is hidden in it."""

    design: Design
    axis: CommandedAxis | ForcedAxis | RangeSensor
    rows: Rows

    @property
    def motion(self) -> Motion:
        """What was asked for."""
        return self.axis.motion

    def moved(self, sizes: Sizes) -> Run:
        """After the motion; only an axis driven by effort moves otherwise for its faults."""
        axis = self.axis
        return replace(self, axis=axis.run(sizes)) if isinstance(axis, ForcedAxis) else self


def prepare(plan: Design, rng: np.random.Generator, share: float = 1.0) -> Run:
    """One motion of the machine and the rows it is read at; share: of the length that was drawn."""
    pace = replace(plan.pace, seconds=max(share * plan.pace.seconds, 20.0))
    motion = move(plan.style, pace, rng)
    if plan.machine == "range":
        nearest = 0.3 + 0.2 * plan.pace.stroke
        motion = replace(motion, position=motion.position - motion.position.min() + nearest)
    other = neighbour(motion, rng)
    load = _load(plan, motion, rng)
    start = -1.0 if plan.style in ONE_WAY else float(rng.uniform(-0.8, 0.8))
    axis: CommandedAxis | ForcedAxis | RangeSensor
    if plan.machine == "commanded":
        axis = CommandedAxis(motion, plan.step_size, load, other, start=start)
    elif plan.machine == "effort":
        width = min(120.0 / plan.pace.stroke_s, 0.1 / motion.step_s)
        axis = ForcedAxis(motion, plan.inertia, plan.gravity, plan.weight, load, other, width)
    else:
        slow = neighbour(replace(motion, stroke_s=0.15 * pace.seconds), rng)
        axis = RangeSensor(motion, slow)
    rows = Rows.drawn(motion.t_s[-1], plan.rate_hz, plan.mess, rng)
    return Run(plan, axis, rows)


def _load(plan: Design, motion: Motion, rng: np.random.Generator) -> FloatArray:
    """A known pull that is changed now and then, as by weights hung on it."""
    if not plan.loaded:
        return np.zeros_like(motion.t_s)
    force = plan.inertia * motion.stroke / motion.stroke_s**2
    count = int(motion.t_s[-1] / (4.0 * motion.stroke_s)) + 2
    pulls = force * rng.choice([0.0, 2.0, 5.0, -3.0], count)
    edges = np.arange(count) * 4.0 * motion.stroke_s
    ramp = 0.3 * motion.stroke_s
    times = np.column_stack([edges, edges + 4.0 * motion.stroke_s - ramp]).ravel()
    load: FloatArray = np.interp(motion.t_s, times, np.repeat(pulls, 2))
    return load


def scale_of(run: Run) -> Scale:
    """What sizes are measured by in this motion; of an axis with effort after it was moved."""
    motion, plan = run.motion, run.design
    speed = np.abs(np.gradient(motion.position, motion.step_s))
    force = highest = 0.0
    if isinstance(run.axis, ForcedAxis):
        _, _, asked = run.axis.recorded(run.rows.true_s)
        highest = float(np.abs(asked).max())
        force = float(np.sqrt(np.mean(asked**2)))
    load = getattr(run.axis, "load", np.zeros(1))
    return Scale(
        length=motion.stroke,
        time=motion.stroke_s,
        speed=float(np.quantile(speed, 0.98)),
        period=1.0 / plan.rate_hz,
        span=float(motion.t_s[-1]),
        force=force,
        inertia=plan.inertia,
        step=plan.step_size,
        load=float(np.sqrt(np.mean(load**2))),
        highest=highest,
        fastest=float(speed.max()),
        away=float(motion.position.max()),
    )


def observer_of(run: Run) -> Observer:
    """The ideal observer of a run."""
    plan, rows_s = run.design, run.rows.true_s
    if not isinstance(run.axis, ForcedAxis):
        used = np.ones(len(rows_s), dtype=bool)
        free = plan.machine == "commanded" and not plan.absolute
        return Observer(run.axis, rows_s, plan.noise, used, free)
    used = run.axis.informative(rows_s)
    every = max(int(0.1 * plan.pace.stroke_s * plan.rate_hz), 5)
    every = min(every, max(int(used.sum()) // 20, 1))
    return Observer(run.axis, rows_s, force_noise(plan, every), used, False, every)


def force_noise(plan: Design, every: int) -> Noise:
    """Noise of a force from an average effort and the curvature of as many positions.

    A parabola through m positions of scatter s, h apart, has a second derivative of variance
    720 s^2 / (h^4 m (m^2 - 1)(m^2 - 4)); a correlation rho makes slow noise (1 + rho) / (1 - rho)
    times as strong.
    """
    m, h = float(max(every, 3)), 1.0 / plan.rate_hz
    bend = 720.0 / (m * (m**2 - 1.0) * (m**2 - 4.0)) / h**4
    own = plan.effort_noise.scatter**2 / m * _slow(plan.effort_noise.rho)
    curved = plan.inertia**2 * plan.noise.scatter**2 * bend * _slow(plan.noise.rho)
    return Noise(float(np.sqrt(own + curved)))


def _slow(rho: float) -> float:
    return (1.0 + rho) / (1.0 - rho)


def untidy(run: Run, rng: np.random.Generator) -> float:
    """Root mean square of what a log adds, with outliers and held rows, as one realisation has it.

    Of a force: of single efforts, or of half the smoothing that the observer uses.
    """
    plan, rows = run.design, run.rows
    if not isinstance(run.axis, ForcedAxis):
        clean = run.axis.clean({}, rows.true_s)
        return _rms(plan.noise.read(clean, rng)[rows.shown] - clean)
    at, _, asked = run.axis.recorded(rows.true_s)
    used = run.axis.informative(rows.true_s)
    off = plan.noise.read(at, rng)[rows.shown] - at
    window = max(observer_of(run).every // 2, 2) * 2 + 1
    bend = savgol_filter(off, window, 2, deriv=2, delta=1.0 / plan.rate_hz)[used]
    single = plan.effort_noise.read(asked, rng)[used] - asked[used]
    return float(np.hypot(plan.inertia * _rms(bend), _rms(single)))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
