"""One case of a chosen kind: `python -m deltactl.proof.generate --kind KIND --seed S --out DIR`.

KIND is an effect of the vocabulary, an oddity beyond it, several with a comma between, `nothing`,
or `tolerance` (build tolerances everywhere, with `--culprit KIND`). Writes recording.csv.gz,
holdout.csv.gz, robot.yaml and answers.json. With `--number N` instead of `--kind` it writes case
N of `deltactl demo prove --seed S`, with `--more N` one of its second set, and with `--axis S` the
case of seed S of `deltactl demo prove --machine axis`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.proof.axis import cases as axis_cases
from deltactl.proof.cases import Case, assemble, draw, draw_more, write_answers, write_blind
from deltactl.proof.hidden.more_oddities import UNKNOWN
from deltactl.proof.hidden.vocabulary import VOCABULARY
from deltactl.proof.motions import SHAPES


def main() -> None:
    """Parse, draw, simulate, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--kind")
    what.add_argument("--number", type=int)
    what.add_argument("--more", type=int)
    what.add_argument("--axis", type=int)
    parser.add_argument("--culprit", default=None)
    parser.add_argument("--seed", type=int, help="of all but --axis")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--strength", type=float, default=1.0, help="1 is moderate, 0.33 faint")
    parser.add_argument("--motion", choices=["survey", *SHAPES], default="survey")
    parser.add_argument("--seconds", type=float, default=None)
    chosen = parser.parse_args()
    if chosen.axis is not None:
        print(_single_axis(chosen.axis, chosen.out))
        return
    if chosen.seed is None:
        parser.error("--seed: which one?")
    try:
        case = _case(chosen)
        write_blind(case, chosen.out, chosen.seed)
        write_answers(case, chosen.out / "answers.json")
    except DeltactlError as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    print(f"{chosen.out}: {', '.join(part.effect for part in case.answers) or 'nothing'}")


def _single_axis(seed: int, out: Path) -> str:
    """Write the case of a seed; returns what is hidden in it."""
    case = axis_cases.draw(seed)
    axis_cases.write_blind(case, out)
    axis_cases.write_answers(case, out / "answers.json")
    return f"{out}: {', '.join(cause.kind.effect for cause in case.hidden) or 'nothing'}"


def _case(chosen: argparse.Namespace) -> Case:
    if chosen.number is not None:
        return draw(chosen.seed, chosen.number)
    if chosen.more is not None:
        return draw_more(chosen.seed, chosen.more)
    kinds = _kinds(chosen.culprit if chosen.kind == "tolerance" else chosen.kind)
    group = "tolerance" if chosen.kind == "tolerance" else "generated"
    rng = np.random.default_rng([chosen.seed, 7])
    return assemble(0, group, kinds, rng, chosen.motion, chosen.seconds, chosen.strength)


def _kinds(text: str | None) -> list[str]:
    if text in (None, "nothing"):
        return []
    kinds = str(text).split(",")
    for kind in kinds:
        if kind not in VOCABULARY and kind not in UNKNOWN:
            known = ", ".join(["nothing", *VOCABULARY, *UNKNOWN])
            raise ConfigError(f"--kind: '{kind}' is not one of {known}")
    return kinds


if __name__ == "__main__":
    main()
