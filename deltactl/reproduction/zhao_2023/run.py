"""`deltactl network reproduce zhao-2023`: all stages, then tables, a page and a Markdown file."""

from __future__ import annotations

from pathlib import Path

from deltactl.charts.page import HINT, columns, heading, page, paragraph
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import DeltactlError, RecordingError
from deltactl.models.training.train import Recipe, settings_in_file
from deltactl.reproduction.outcome import Outcome, Sheet, check_writable, write
from deltactl.reproduction.zhao_2023 import beyond, figures, tables
from deltactl.reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built
from deltactl.reproduction.zhao_2023.study import FULL, GEOMETRY, QUICK, Say, Study
from deltactl.reproduction.zhao_2023.tracking import CURVES

ROBOT = "zhao-2023.yaml"
TITLE = "Zhao 2023 over again"
LEAD = (
    "Zhao, Toudeshki, Ehsani and Sun, Robotics 2023, 12, 135: a stepper delta steered by a deep "
    "network, open loop. The robot here is a simulated one as a workshop may have built it; its "
    "figures, and where each is from, are in reproduction/zhao_2023/as_built.yaml."
)
RECIPES: tuple[tuple[str, Recipe], ...] = (("Zhao's", "zhao"), ("Uzunovic's", "uzunovic"))
DIFFERS = (
    "Zhao's robot was never measured; home angles, lengths and sensor errors of ours were chosen "
    "so that geometry errs by about as much as in Table 3. The geometry rows therefore agree by "
    "construction; what the study finds is how networks do on such a robot.",
    "By its own sensors the network's error here is little more than the sensors' noise: it has "
    "learned their bias along with the robot, and is judged with the same bias. The paper's "
    "figures (z 11 mm at all speeds, by sensors) cannot be a constant bias of the same sensors; "
    "against the truth, which the paper could not see, ours are of that size.",
    "Speed hardly matters: a stepper in closed loop follows its pulses. The paper's spiral is "
    "worse at 0.01 s than at 0.002 and 0.02 s, without a reason given; nothing here does that.",
    "Sizes and heights of the curves are not printed in the paper; ours are in "
    "reproduction/zhao_2023/tracking.py.",
    "The survey is taken from rest to rest without simulating the days in between "
    "(reproduction/zhao_2023/settling.py); the curves are simulated in time by MuJoCo.",
    "The paper's recipe as printed does not learn (deltactl network train and docs say what was"
    " added).",
)


def sheets_of(study: Study) -> list[Sheet]:
    """All tables, in the order of the paper."""
    return [
        tables.table_3(study),
        tables.table_4(study),
        tables.greatest(study),
        tables.ablation_samples(study),
        tables.ablation_trajectory(study),
        beyond.diagnosed(study),
        beyond.above_the_limit(study),
        beyond.few_samples(study),
        beyond.apart_from_the_limit(study),
        *beyond.samples_tables(study),
    ]


def recipes(effort: int | None) -> str:
    """What the papers' networks were trained with: whoever reads an old table can tell."""
    each = []
    for whose, recipe in RECIPES:
        said = ", ".join(
            f"{name} {value}" for name, value in settings_in_file(recipe, effort).items()
        )
        each.append(f"{whose} network: {said}.")
    return " ".join(each)


def html_of(study: Study, found: list[Sheet]) -> str:
    """The page."""
    network = f"zhao-{study.scale.main}"
    parts = [paragraph(HINT, "note howto"), paragraph(recipes(study.scale.effort), "note")]
    parts += [*(sheet.html() for sheet in found[:3])]
    parts += [heading("Where ours differs from print, and why")]
    parts += [paragraph(text) for text in DIFFERS]
    parts += [heading("The data (Figures 4 and 5)")]
    parts += [chart.html() for chart in figures.counts_charts(study)]
    parts += [columns(chart.html() for chart in figures.position_charts(study))]
    parts += [heading("The curves (Figures 7 to 9)")]
    for number, curve in enumerate(CURVES, start=7):
        parts += [columns(c.html() for c in figures.path_charts(study, number, curve))]
    parts += [heading("The errors (Figures 10 to 15)")]
    number = 10
    for curve in CURVES:
        for model in (GEOMETRY, network):
            charts = figures.error_charts(study, number, curve, model)
            parts += [chart.html() for chart in charts]
            number += 1
    parts += [heading("How much data, and which"), *(sheet.html() for sheet in found[3:5])]
    parts += [heading("Beyond the paper"), *(sheet.html() for sheet in found[5:])]
    parts += [chart.html() for chart in figures.samples_charts(study)]
    return page(TITLE, parts, LEAD)


def markdown_of(study: Study, found: list[Sheet], command: str) -> str:
    """The tables for docs, with the command that made them."""
    lines = [f"Printed by `{command}`. {recipes(study.scale.effort)}", ""]
    for sheet in found:
        lines += [sheet.markdown(), ""]
    lines += ["**Where ours differs from print, and why**", ""]
    lines += [f"- {text}" for text in DIFFERS]
    return "\n".join(lines) + "\n"


def diagnosed_only(folder: Path, quick: bool, say: Say) -> Sheet:
    """The one table that needs no network. Raises ConfigError or RecordingError."""
    check_writable(folder)
    return beyond.diagnosed(_study(folder, quick, say))


def reproduce(folder: Path, quick: bool, say: Say) -> Outcome:
    """Run what is missing in the folder. Raises ConfigError or RecordingError."""
    check_writable(folder)
    study = _study(folder, quick, say)
    command = f"deltactl network reproduce zhao-2023{' --quick' if quick else ''}"
    try:
        sheets = sheets_of(study)
        html, markdown = html_of(study, sheets), markdown_of(study, sheets, command)
    except OSError as error:
        if isinstance(error, DeltactlError):
            raise
        raise RecordingError(
            f"{folder}: cannot be written ({error.strerror or error}); what is done is kept, the "
            "same command goes on from there"
        ) from error
    return write(folder, sheets, html, markdown)


def _study(folder: Path, quick: bool, say: Say) -> Study:
    robot = load_robot(find(ROBOT))
    built = load_as_built(AS_BUILT_FILE, robot)
    return Study(folder, robot, built, QUICK if quick else FULL, say)
