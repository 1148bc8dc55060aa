"""What a release says of itself is the same in every place."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_citation_names_version_license_and_authors_of_the_project() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors", "version"} <= citation.keys()
    for key in ("version", "license"):
        assert citation[key] == PROJECT[key]
    assert [one["name"] for one in citation["authors"]] == [
        one["name"] for one in PROJECT["authors"]
    ]


def test_the_version_is_in_the_list_of_changes() -> None:
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    heads = re.findall(r"^## \[(.+?)\]", changes, re.M)
    candidate = re.search(r"^Release candidate (\S+)\.$", changes, re.M)
    assert PROJECT["version"] in [*heads, candidate and candidate[1]]


def test_classifiers_name_the_pythons_that_are_required() -> None:
    named = {
        int(one.rsplit(".", 1)[1])
        for one in PROJECT["classifiers"]
        if one.startswith("Programming Language :: Python :: 3.")
    }
    oldest = int(PROJECT["requires-python"].removeprefix(">=3."))
    assert named == set(range(oldest, max(named) + 1))
    assert (ROOT / "deltactl" / "py.typed").is_file()
