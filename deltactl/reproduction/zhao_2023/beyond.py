"""Beyond the paper: errors against the truth, above the limit, and by number of samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.reproduction.outcome import Sheet
from deltactl.reproduction.zhao_2023.study import (
    CALIBRATED,
    CORRECTED,
    GEOMETRY,
    LIMIT,
    RECIPES,
    TRUSTING,
    Study,
)
from deltactl.reproduction.zhao_2023.tracking import CURVES, TITLES, distance_m, rms_m


@dataclass(frozen=True)
class Cell:
    """One curve at one speed: RMS distances to the curve [m]."""

    curve: str
    t_pwm_s: float
    error_m: dict[str, float]
    """To the curve, by model."""
    apart_m: dict[str, float]
    """To where the limit's run was at the same target, by model."""

    @property
    def head(self) -> list[str]:
        """Curve and speed as the first columns of a table."""
        return [TITLES[self.curve], f"{self.t_pwm_s:g}"]

    def above_m(self, model: str) -> float:
        """Error of a model less that of the limit; below 0 is better than the limit."""
        return self.error_m[model] - self.error_m[LIMIT]

    def holds(self, ours: str, zhao: str) -> bool:
        """Whether ours is above the limit by at most half of what Zhao's network is."""
        return self.above_m(ours) <= 0.5 * max(self.above_m(zhao), 0.0)


def _mm(*errors_m: float) -> list[str]:
    return [f"{1e3 * error_m:.2f}" for error_m in errors_m]


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


def cells(study: Study) -> list[Cell]:
    """All curves and speeds."""
    main, few = study.scale.main, study.scale.few
    models = [GEOMETRY, LIMIT, *(f"{recipe}-{main}" for recipe in RECIPES)]
    models += [f"{name}-{count}" for name in (CALIBRATED, TRUSTING) for count in (main, few)]
    models += [f"ours-{few}"]
    return [_cell(study, models, curve, speed) for curve in CURVES for speed in study.scale.speeds]


def _cell(study: Study, models: list[str], curve: str, t_pwm_s: float) -> Cell:
    tracks = {model: study.track(model, curve, t_pwm_s) for model in models}
    limit_m = tracks[LIMIT].true_m
    return Cell(
        curve,
        t_pwm_s,
        {model: distance_m(track.true_error_m) for model, track in tracks.items()},
        {model: distance_m(track.true_m - limit_m) for model, track in tracks.items()},
    )


def diagnosed(study: Study) -> Sheet:
    """Diagnosed and corrected from one survey, on all curves and speeds."""
    rows = []
    for curve in CURVES:
        for speed in study.scale.speeds:
            true_m = {m: study.track(m, curve, speed).true_error_m for m in (GEOMETRY, CORRECTED)}
            closed_true_m, closed = study.true_with_feedback(curve, speed)
            closed_m = closed_true_m - study.targets(curve)
            rows.append(
                [
                    TITLES[curve],
                    f"{speed:g}",
                    *_mm(*map(distance_m, (*true_m.values(), closed_m))),
                    *_mm(*rms_m(true_m[CORRECTED]), *rms_m(closed_m)),
                    _yes(closed),
                ]
            )
    known, everything = (
        ", ".join(f"{entry.effect} on {entry.component}" for entry in robot.effects) or "nothing"
        for robot in (study.corrected, study.corrected_all)
    )
    head = ["Curve", "T_PWM", "geometry", "corrected", "with feedback"]
    head += [f"{words}e_{axis}" for words in ("", "with feedback ") for axis in "xyz"]
    head.append("closed")
    return Sheet(
        f"Diagnosed and corrected from one survey of {study.scale.survey_s / 60.0:g} minutes: "
        "error against the truth, RMS [mm]",
        head,
        rows,
        1,
        "Feedback corrects what came since a run began; on a robot whose model is this far off it "
        "takes errors that vary along the path for such. Closed: the same steps came out of two "
        "passes; else the figure is that of the last pass. "
        f"Written into the robot file: {known}; with --all: {everything}. "
        f"Zhao's network, trained on {study.scale.main} poses, is in the table of errors against "
        "the truth.",
    )


def above_the_limit(study: Study) -> Sheet:
    """Each model's true error, and by how much it exceeds that of the limit."""
    main = study.scale.main
    zhao, ours = f"zhao-{main}", f"ours-{main}"
    models = (GEOMETRY, f"uzunovic-{main}", zhao, LIMIT, ours, f"{CALIBRATED}-{main}")
    rows = []
    for cell in cells(study):
        above = [f"{1e3 * cell.above_m(model):+.2f}" for model in (zhao, ours)]
        shown_m = [cell.error_m[model] for model in models]
        rows.append([*cell.head, *_mm(*shown_m), *above, _yes(cell.holds(ours, zhao))])
    return Sheet(
        f"Error against the truth, RMS distance [mm], trained on {main} samples",
        [
            *("Curve", "T_PWM", "geometry", "Uzunovic's", "Zhao's", "limit", "ours", "calibrated"),
            *("Zhao's above limit", "ours above limit", "at most half"),
        ],
        rows,
        1,
        "Limit: the exact inverse of what the sensors read on average, which a model that takes "
        "them at their word would reach with unlimited data. Ours lies below it: knowing the "
        "linkage, a calibration separates most of a sensor's offset from an arm's.",
    )


def apart_from_the_limit(study: Study) -> Sheet:
    """Distances from the limit's own run, which leave the sensors' bias aside altogether."""
    main, few = study.scale.main, study.scale.few
    rows = []
    for cell in cells(study):
        apart = cell.apart_m
        zhao, ours = apart[f"zhao-{main}"], apart[f"{TRUSTING}-{main}"]
        early = apart[f"{TRUSTING}-{few}"]
        shown = [*_mm(apart[f"uzunovic-{main}"], zhao, ours), f"{ours / zhao:.2f}"]
        shown += [_yes(ours <= 0.5 * zhao), *_mm(early), _yes(early <= zhao)]
        rows.append([*cell.head, *shown])
    return Sheet(
        "Distance from the limit's own run, RMS [mm]: what a model adds to the sensors' bias",
        [
            *("Curve", "T_PWM", f"Uzunovic's, {main}", f"Zhao's, {main}", f"ours, {main}"),
            *("ours / Zhao's", "at most half", f"ours, {few}", "no worse than Zhao's"),
        ],
        rows,
        1,
        "Here ours aims, like the networks, at what the sensors will read: the calibrated robot "
        "with its sensor errors left in.",
    )


def few_samples(study: Study) -> Sheet:
    """Ours trained on few samples against Zhao's network trained on many."""
    main, few = study.scale.main, study.scale.few
    rows = []
    for cell in cells(study):
        ours, zhao = cell.error_m[f"ours-{few}"], cell.error_m[f"zhao-{main}"]
        shown = _mm(ours, cell.error_m[f"{CALIBRATED}-{few}"], zhao)
        rows.append([*cell.head, *shown, _yes(ours <= zhao)])
    return Sheet(
        f"Ours with {few} samples against Zhao's with {main}: RMS distance to the truth [mm]",
        ["Curve", "T_PWM", f"ours, {few}", f"calibrated, {few}", f"Zhao's, {main}", "no worse"],
        rows,
        1,
    )


def by_samples(study: Study) -> dict[str, FloatArray]:
    """Mean over the three curves of the RMS distance to the truth [m], by model, (sizes,)."""
    sizes = study.scale.samples
    found: dict[str, FloatArray] = {}
    for model in (*RECIPES, CALIBRATED):
        found[model] = np.array([_mean(study, f"{model}-{count}") for count in sizes])
    for model in (GEOMETRY, LIMIT):
        found[model] = np.full(len(sizes), _mean(study, model))
    return found


def apart_by_samples(study: Study) -> dict[str, FloatArray]:
    """The same of the distance to the limit's own run."""
    models = ("zhao", "uzunovic", TRUSTING)
    return {
        model: np.array([_mean_apart(study, f"{model}-{count}") for count in study.scale.samples])
        for model in models
    }


def samples_tables(study: Study) -> list[Sheet]:
    """Error and distance from the limit's run by number of samples."""
    head = ["model", *(str(count) for count in study.scale.samples)]
    where = "by number of samples, mean of the three curves at T_PWM 0.006 s [mm]"
    return [
        Sheet(f"Error against the truth {where}", head, _rows(by_samples(study))),
        Sheet(f"Distance from the limit's run {where}", head, _rows(apart_by_samples(study))),
    ]


NAMES = {"zhao": "Zhao's", "uzunovic": "Uzunovic's", TRUSTING: "ours, trusting the sensors"}


def _rows(found: dict[str, FloatArray]) -> list[list[str]]:
    return [[NAMES.get(model, model), *_mm(*values)] for model, values in found.items()]


def _mean(study: Study, model: str) -> float:
    return float(np.mean([distance_m(study.track(model, c).true_error_m) for c in CURVES]))


def _mean_apart(study: Study, model: str) -> float:
    apart = [study.track(model, c).true_m - study.track(LIMIT, c).true_m for c in CURVES]
    return float(np.mean([distance_m(error_m) for error_m in apart]))
