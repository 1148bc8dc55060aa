"""The text of a robot file with other effects, or another model; comments elsewhere are kept."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml

from deltactl.foundation.strict_yaml import Document
from deltactl.models.robot import EffectEntry
from deltactl.models.robot_files import named_for_file

HEADING = "# Found by deltactl diagnose; known from now on and part of the model."
_MODEL = re.compile(r"^model:.*$", re.MULTILINE)
_SECTION = re.compile(r"^effects:.*\n?(?:(?:[ \t#-].*)?\n)*", re.MULTILINE)


def with_effects(text: str, entries: Iterable[EffectEntry], slides: bool = False) -> str:
    """The text of a robot file with other effects; slides: of an axis that does."""
    plain = [_plain(entry) for entry in entries]
    if slides:
        plain = [named_for_file(one) for one in plain]
    block = yaml.safe_dump({"effects": plain}, sort_keys=False) if plain else ""
    if text.lstrip("\ufeff \t\n").startswith("{"):  # one value in braces has no section to replace
        data = Document(Path("robot"), text).data
        text = yaml.safe_dump({key: data[key] for key in data if key != "effects"}, sort_keys=False)
    rest = _SECTION.sub("", text.replace(f"{HEADING}\n", "").rstrip() + "\n").rstrip()
    return f"{rest}\n\n{HEADING}\n{block}" if block else f"{rest}\n"


def with_model(text: str, model: str) -> str:
    """The text of a chain's robot file with another model, relative to where it is written."""
    return _MODEL.sub(f"model: {model}", text)


def _plain(entry: EffectEntry) -> dict[str, Any]:
    """An entry as the file has it: what was not found or allowed for goes without saying."""
    plain = entry.model_dump(mode="json", exclude_none=True)
    for key in ("loosely_built", "spread"):
        if entry.found is not None and not getattr(entry.found, key):
            del plain["found"][key]
    return plain
