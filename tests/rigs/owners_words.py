"""The printed options of a table with what fits it in place of the words that its owner puts."""

from __future__ import annotations

from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.units import LONE


def owner_says(found: Inspection) -> list[str]:
    """Options as `--set` takes them, with a unit or a number in place of each word."""
    of = found.mapping.columns
    unit = next((one.unit for name, one in of.items() if name in LONE), "")
    words = {"=UNIT": f"={unit}"}
    words |= {factor.word: f"{of[name].scale:.12g}" for name, factor in found.factors.items()}
    options = [option for option in found.options if option != "--set"]
    for word, text in words.items():
        options = [option.replace(word, text) for option in options]
    return options
