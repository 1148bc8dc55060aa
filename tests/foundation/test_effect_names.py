"""Nothing outside models/effects names an effect, but for what is listed here and may only shrink.

Counted are string literals that are the name of a registered effect, alone or before a dot. Where
one effect is meant (a calibration is written as effects), its operator is imported.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.structure import ROOT
from deltactl.models.effects import CARDS

FOLDERS = ("benchmarks", "deltactl", "drivers", "firmware_py", "models")
CARDS_STAND_IN = Path("models/effects")
PROOF = Path("deltactl/proof")
"""The blind proof shares no code with the models: it says what it hides by the contract's names."""
OUTSIDE = Path("benchmarks/rivals")
"""Other tools run where deltactl is not installed: their protocols use the contract's names."""

EXPERIMENT = {"benchmarks/proofs/detection_limit.py": 8}
"""What an experiment hides, by the contract's names, as `proof` does."""
HOMONYMS = {
    "benchmarks/proofs/recording_variations.py": 2,
    "deltactl/cli/recordings/init.py": 3,
    "deltactl/diagnosis/plants/lone/force_shapes.py": 2,
    "deltactl/diagnosis/plants/lone/forced_axis.py": 3,
    "models/rigid_chain.py": 1,
    "models/robot.py": 2,
    "deltactl/reference/words.py": 2,
    "firmware_py/exporting/urdf.py": 1,
    "deltactl/repair/corrected_model.py": 1,
    "firmware_py/robot_file.py": 1,
    "firmware_py/describing/questions.py": 3,
    "firmware_py/describing/robot_text.py": 5,
}
"""Keys of robot files, questions of `deltactl init`, a tag of URDF, and a parameter that have an
effect's name."""
ALLOWED = EXPERIMENT | HOMONYMS


def sources(root: Path) -> Iterator[Path]:
    """Python files, each by its real path alone."""
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.py")):
            inside = path.relative_to(root)
            linked = any((root / part).is_symlink() for part in inside.parents)
            if not linked and not {CARDS_STAND_IN, PROOF, OUTSIDE} & set(inside.parents):
                yield path


def names_in(text: str) -> list[str]:
    """Names of effects among the literals of a source, also as keys like 'gear_ratio.small'."""
    literals = (node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant))
    names = (one.partition(".")[0] for one in literals if isinstance(one, str))
    return [name for name in names if name in CARDS]


def counted(root: Path) -> dict[str, int]:
    """Literals by file, of files that have any; `unknown` names no effect."""
    found = {}
    for path in sources(root):
        names = [name for name in names_in(path.read_text(encoding="utf-8")) if name != "unknown"]
        if names:
            found[path.relative_to(root).as_posix()] = len(names)
    return found


def wrong(found: dict[str, int], allowed: dict[str, int]) -> list[str]:
    """A line for each file that names more effects than it may, or fewer than it is listed with."""
    lines = []
    for file in sorted({*found, *allowed}):
        is_, may = found.get(file, 0), allowed.get(file, 0)
        if is_ > may:
            lines.append(f"{file}: {is_} names of effects, {may} are allowed: ask the card instead")
        if is_ < may:
            lines.append(f"{file}: {is_} names of effects: set its entry of ALLOWED from {may}")
    return lines


def test_effects_are_named_in_their_own_files_only() -> None:
    assert wrong(counted(ROOT), ALLOWED) == []


@pytest.mark.parametrize(("allowed", "says"), [(0, "ask the card"), (2, "set its entry")])
def test_a_name_more_and_a_name_less_are_seen(tmp_path: Path, allowed: int, says: str) -> None:
    for folder in FOLDERS:
        (tmp_path / folder).mkdir()
    (tmp_path / "drivers" / "a.py").write_text('ODDS = {"home_offset": 0.1, "other": 0.2}\n')
    (tmp_path / "models" / "effects").mkdir()
    (tmp_path / "models" / "effects" / "b.py").write_text('NAME = "home_offset"\n')
    (tmp_path / "deltactl" / "models").symlink_to(tmp_path / "models")
    (line,) = wrong(counted(tmp_path), {"drivers/a.py": allowed} if allowed else {})
    assert line.startswith("drivers/a.py: 1 ")
    assert says in line
