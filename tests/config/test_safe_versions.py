"""No version that an advisory names is pinned or installed, as far as this table knows.

The table is written by hand from published advisories, because the tests run without a network.
Whoever changes a pin, or hears of an advisory, adds a line. `pip-audit -r constraints.txt` asks the
advisory database itself, where there is a network.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

CONSTRAINTS = Path(__file__).resolve().parents[2] / "constraints.txt"
AS_OF = "2026-11-26"
SAFE = {
    "aiohttp": ("3.14.3", "CVE-2026-69243 CVE-2026-69244 CVE-2026-54273 CVE-2026-34993"),
    "certifi": ("2024.7.4", "CVE-2024-39689"),
    "dask": ("2021.10.0", "CVE-2021-42343"),
    "fastapi": ("0.109.1", "CVE-2024-24762"),
    "h11": ("0.16.0", "CVE-2025-43859"),
    "idna": ("3.7", "CVE-2024-3651"),
    "jinja2": ("3.1.6", "CVE-2025-27516"),
    "nicegui": ("3.12.0", "CVE-2026-45553 CVE-2026-45554 CVE-2026-33332 CVE-2026-27156"),
    "numpy": ("1.22.2", "CVE-2021-41496"),
    "orjson": ("3.11.6", "CVE-2025-67221"),
    "pillow": ("12.3.0", "PYSEC-2026-2253 PYSEC-2026-2257 CVE-2026-40192"),
    "protobuf": ("6.33.5", "CVE-2026-0994"),
    "pyarrow": ("23.0.1", "CVE-2026-25087 CVE-2023-47248"),
    "pydantic": ("2.4.0", "CVE-2024-3772"),
    "pygments": ("2.15.1", "CVE-2022-40896"),
    "python-engineio": ("4.13.2", "CVE-2026-48802 CVE-2026-48809"),
    "python-multipart": ("0.0.31", "CVE-2026-53540 CVE-2026-53539 CVE-2026-42561"),
    "python-socketio": ("5.16.2", "CVE-2026-48804 CVE-2025-61765"),
    "pyyaml": ("5.4", "CVE-2020-14343"),
    "scipy": ("1.10.0", "CVE-2023-25399"),
    "starlette": ("1.3.1", "CVE-2026-54283 CVE-2026-54282 CVE-2026-48710 CVE-2025-62727"),
    "tornado": ("6.5", "CVE-2025-47287"),
    "urllib3": ("2.7.0", "CVE-2026-44431 CVE-2026-44432 CVE-2026-21441"),
    "uvicorn": ("0.11.7", "CVE-2020-7694 CVE-2020-7695"),
    "websockets": ("9.1", "CVE-2021-33880"),
}
"""Package: the first version without what the advisories describe, and the newest of those."""
LISTENING = ("aiohttp", "h11", "nicegui", "python-engineio", "python-multipart", "python-socketio",
             "starlette", "uvicorn", "websockets")  # fmt: skip
"""Take part in answering a browser."""


def pinned() -> list[tuple[str, Version]]:
    """What constraints.txt pins; a package has a line for each Python where they differ."""
    found = []
    for line in CONSTRAINTS.read_text(encoding="utf-8").splitlines():
        text = line.split("#")[0].strip()
        if text:
            wanted = Requirement(text)
            (one,) = wanted.specifier
            assert one.operator == "==", line
            found.append((canonicalize_name(wanted.name), Version(one.version)))
    return found


def unsafe(found: list[tuple[str, Version]]) -> list[str]:
    return [f"{name} {its} is below {SAFE[name][0]}: {SAFE[name][1]}" for name, its in found
            if name in SAFE and its < Version(SAFE[name][0])]  # fmt: skip


def test_nothing_is_pinned_that_an_advisory_names() -> None:
    assert not unsafe(pinned())


def test_nothing_is_installed_that_an_advisory_names() -> None:
    found = []
    for name in SAFE:
        try:
            found.append((name, Version(version(name))))
        except PackageNotFoundError:
            continue
    assert len(found) > 10
    assert not unsafe(found)


def test_the_table_is_of_packages_that_are_pinned_and_names_its_sources() -> None:
    names = {name for name, _ in pinned()}
    assert SAFE.keys() <= names, "a package that has gone needs no line"
    assert set(LISTENING) <= SAFE.keys()
    for least, sources in SAFE.values():
        assert Version(least).is_prerelease is False
        assert all(one.startswith(("CVE-", "PYSEC-", "GHSA-")) for one in sources.split())


@pytest.mark.parametrize("name", sorted(SAFE))
def test_a_version_before_the_first_safe_one_is_found(name: str) -> None:
    assert unsafe([(name, Version("0.0.0"))])
    assert not unsafe([(name, Version(SAFE[name][0]))])
