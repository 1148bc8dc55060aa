"""Section 5 of Uzunovic 2013 over again: both experiments, and what the paper does not show.

python -m deltactl.reproduction.uzunovic_2013.control --out DIR [--quick]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console

from deltactl.charts.page import heading, page, paragraph
from deltactl.foundation.plain_file import write_whole
from deltactl.reproduction.outcome import Sheet
from deltactl.reproduction.uzunovic_2013.control_loop import (
    EXPERIMENTS,
    WHOLE_S,
    References,
    micro_delta,
    references,
    shipped_network,
)
from deltactl.reproduction.uzunovic_2013.control_results import (
    Result,
    observer_table,
    reference_figure,
    response_figures,
    speed_table,
    tracking_table,
)
from deltactl.reproduction.uzunovic_2013.control_variants import (
    NOTHING,
    OURS,
    PAPER,
    TROUBLES,
    Control,
    Trouble,
    simulate,
)

Progress = Callable[[int, int, str], None]
"""Called with the number of runs that are done, of how many, and the next one."""
TITLE = "Section 5: the micro delta under acceleration control"
QUICK_TROUBLES = (NOTHING,)
LEAD = (
    "Cartesian reference, network inverse kinematics, gear, reference filter and acceleration "
    "control with disturbance observer (equations 5 and 6) at 10 kHz, on a robot made "
    "independently in MuJoCo: bodies, gears, friction, gravity, encoders of 0.01 degrees. Masses, "
    "friction, gear and motor constants are not published; proof/micro/as_built.py says what was "
    "taken. Until t = 1 s the arms rest at 30 degrees."
)


@dataclass(frozen=True)
class ControlPart:
    """What section 5 gives to a report: tables as text and figures as HTML."""

    results: list[Result]
    sheets: list[Sheet]
    figures: list[str] = field(repr=False)

    def html(self) -> list[str]:
        """Pieces for `deltactl.charts.page.page`: heading, text, tables, figures."""
        sheets = (sheet.html() for sheet in self.sheets)
        return [heading(TITLE), paragraph(LEAD), *sheets, *self.figures]


def reproduce_control(
    out_dir: Path | None = None,
    quick: bool = False,
    progress: Progress = lambda done, total, text: None,
) -> ControlPart:
    """Run both experiments and all variants; with `out_dir` write control.html there.

    quick: nothing wrong only, observer on and off.
    Raises what the network raises outside its region.
    """
    _, drive = micro_delta()
    network = shipped_network()
    asked = [references(run, network, drive.period_s, WHOLE_S) for run in EXPERIMENTS]
    results: list[Result] = []
    plan = list(_plan(asked, QUICK_TROUBLES if quick else TROUBLES))
    for number, (run, control, trouble, observed) in enumerate(plan):
        words = f"{run.experiment.name} experiment, {control.name}, {trouble.name}"
        progress(number, len(plan), words if observed else f"{words}, observer off")
        used = control if observed else control.without_observer()
        tracking = simulate(drive, run, used, trouble)
        results.append(Result(run, control, trouble, observed, tracking))
    progress(len(plan), len(plan), "")
    plain = [found for found in results if found.observed and found.trouble is NOTHING]
    part = ControlPart(
        results,
        [tracking_table(plain, drive), observer_table(results), speed_table(results)],
        _figures(plain),
    )
    if out_dir is not None:
        out_dir.mkdir(parents=True, exist_ok=True)
        write_whole(out_dir / "control.html", page(TITLE, part.html()[1:]))
    return part


def _plan(
    asked: Sequence[References], troubles: Sequence[Trouble]
) -> Iterator[tuple[References, Control, Trouble, bool]]:
    for run in asked:
        for trouble in troubles:
            for control in (PAPER, OURS):
                yield run, control, trouble, True
                yield run, control, trouble, False


def _figures(plain: Sequence[Result]) -> list[str]:
    figures: list[str] = []
    for found in plain:
        if found.control is PAPER:
            figures += [reference_figure(found.asked), *response_figures(found)]
        elif found.control is OURS:
            figures += response_figures(found)[3:]
    return figures


def main() -> None:
    """Run it and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for control.html")
    parser.add_argument("--quick", action="store_true", help="only what the paper shows")
    given = parser.parse_args()
    console, said = Console(), Console(stderr=True)

    def show(done: int, total: int, text: str) -> None:
        said.print(f"{done}/{total} {text}")

    for sheet in reproduce_control(given.out, given.quick, show).sheets:
        console.print(sheet.text(), soft_wrap=True)
    console.print(f"report: {given.out / 'control.html'}")


if __name__ == "__main__":
    main()
