"""Cost of one 10 kHz tick of the simulated micro delta, split into law, MuJoCo and the rest.

    python benchmarks/costs/micro.py

Goals: law at most 10 us for three joints; whole experiments at least 5 times faster than real
time, so 20 us a tick. Process CPU time is what the code costs; wall time is longer on a machine
that others use.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, process_time

from rich.console import Console
from rich.table import Table

from deltactl.firmware_py.servo.law import AccelerationControl, LawSettings
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.extras import needs

LAW_GOAL_US, WHOLE_GOAL_US = 10.0, 20.0
ROUNDS = 5


def main() -> None:
    """Measure and print."""
    with needs("proof", "benchmarks/costs/micro.py"):
        from deltactl.proof.micro.bodies import Rods
    from deltactl.proof.micro.as_built import MicroDelta
    from deltactl.proof.micro.plant import MicroPlant
    from deltactl.reproduction.uzunovic_2013.control_loop import (
        EXPERIMENTS,
        START_RAD,
        micro_delta,
        references,
        run,
        shipped_network,
    )

    _, drive = micro_delta()
    settings = LawSettings.of(drive)
    asked = references(EXPERIMENTS[0], shipped_network(), drive.period_s, 3.0)
    whole = min(
        (run(settings, MicroDelta(), asked.t_s, asked.angle_rad) for _ in range(ROUNDS)),
        key=lambda run: run.cpu_s,
    )
    ticks = len(whole.t_s) - whole.on
    rows = list(
        zip(
            whole.reference_rad[whole.on :].tolist(),
            (whole.measured_rad[whole.on :] / drive.rad_per_count).round().astype(int).tolist(),
            strict=True,
        )
    )
    currents = whole.current_a[whole.on :].tolist()

    def law() -> None:
        joints = AccelerationControl(settings).joints
        one, two, three = (joint.tick for joint in joints)
        for (r1, r2, r3), (c1, c2, c3) in rows:
            one(r1, c1), two(r2, c2), three(r3, c3)

    def plant_of(rods: Rods) -> Callable[[], None]:
        plant = MicroPlant(MicroDelta(), START_RAD, rods)

        def go() -> None:
            plant.place(START_RAD)
            advance = plant.advance
            for i1, i2, i3 in currents:
                advance(i1, i2, i3)

        return go

    law_us = _each_us(law, ticks)
    bodies_us = _each_us(plant_of(Rods.BODIES), ticks)
    points_us = _each_us(plant_of(Rods.POINTS), ticks)
    whole_us = (1e6 * whole.cpu_s / ticks, 1e6 * whole.wall_s / ticks)
    rest_us = (whole_us[0] - law_us[0] - bodies_us[0], whole_us[1] - law_us[1] - bodies_us[1])
    table = Table(title=f"One tick, best of {ROUNDS} runs of {ticks} ticks", title_justify="left")
    for head in ("part", "CPU us", "wall us", "goal us"):
        table.add_column(head, justify="left" if head == "part" else "right")
    for name, (cpu, wall), goal in (
        ("law, three joints", law_us, f"{LAW_GOAL_US:g}"),
        ("MuJoCo step, rods as bodies", bodies_us, ""),
        ("rest: encoders, rows kept", rest_us, ""),
        ("whole experiment", whole_us, f"{WHOLE_GOAL_US:g}"),
        ("(MuJoCo step, rods as points)", points_us, ""),
    ):
        table.add_row(name, f"{cpu:.2f}", f"{wall:.2f}", goal)
    console = Console()
    console.print(table)
    period_us = 1e6 * drive.period_s
    console.print(
        f"whole experiments: {period_us / whole_us[0]:.1f} times faster than real time by CPU, "
        f"{period_us / whole_us[1]:.1f} by wall clock"
    )


def _each_us(what: Callable[[], None], ticks: int) -> tuple[float, float]:
    """CPU and wall time a tick, the best of a few rounds."""
    cpu, wall = [], []
    for _ in range(ROUNDS):
        cpu_s, wall_s = process_time(), perf_counter()
        what()
        cpu.append(process_time() - cpu_s)
        wall.append(perf_counter() - wall_s)
    return 1e6 * min(cpu) / ticks, 1e6 * min(wall) / ticks


if __name__ == "__main__":
    try:
        main()
    except DeltactlError as error:
        raise SystemExit(str(error)) from error
