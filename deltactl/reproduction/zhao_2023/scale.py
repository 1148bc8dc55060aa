"""How much of everything: the whole reproduction, or a short one that shows that it runs."""

from __future__ import annotations

from dataclasses import dataclass

from deltactl.reproduction.zhao_2023.curves import T_PWM_S


@dataclass(frozen=True)
class Scale:
    """Samples and effort of a study."""

    samples: tuple[int, ...]
    """Data set sizes to train with, rising."""
    main: int
    """The size of the paper's."""
    few: int
    """The size with which our model shall do as well as Zhao's with `main`."""
    ablation: tuple[int, ...]
    """The sizes the paper compares."""
    speeds: tuple[float, ...] = T_PWM_S
    effort: int | None = None
    """Epochs or iterations; None is each recipe's own."""
    survey_s: float = 240.0
    """Length of the survey that the robot is diagnosed from."""
    part: float = 1.0
    """How much of each curve is followed."""


FULL = Scale(
    samples=(100, 300, 500, 1000, 3000, 5000, 20_000),
    main=5000,
    few=500,
    ablation=(1000, 3000, 5000),
)
QUICK = Scale(
    samples=(100, 200),
    main=200,
    few=100,
    ablation=(100, 200),
    effort=10,
    survey_s=30.0,
    part=0.1,
    speeds=(0.002, 0.006),
)
