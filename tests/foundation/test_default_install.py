"""What plain `pip install .` brings: on a PC the diagnosis, on a Raspberry Pi only the robot."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
PARTS = PROJECT["optional-dependencies"]
PC, PI = ("x86_64", "AMD64", "arm64"), ("aarch64", "armv7l", "armv6l")


def asked_for(requirements: list[str], machine: str, python: str) -> set[str]:
    """Names and versions that pip would look for there."""
    environment = {"platform_machine": machine, "python_version": python, "extra": ""}
    wanted = [Requirement(one) for one in requirements]
    return {
        f"{one.name}{one.specifier}"
        for one in wanted
        if one.marker is None or one.marker.evaluate(environment)
    }


def diagnosis(machine: str, python: str) -> set[str]:
    own = [one for one in PARTS["diagnosis"] if one != "deltactl[charts]"]
    return asked_for([*own, *PARTS["charts"]], machine, python)


@pytest.mark.parametrize("python", ["3.11", "3.13"])
@pytest.mark.parametrize("machine", PC)
def test_on_a_pc_the_default_has_all_of_the_extra(machine: str, python: str) -> None:
    default = asked_for(PROJECT["dependencies"], machine, python)
    on_a_pi = asked_for(PROJECT["dependencies"], "aarch64", python)
    assert default - on_a_pi == diagnosis(machine, python)


@pytest.mark.parametrize("python", ["3.11", "3.13"])
@pytest.mark.parametrize("machine", PI)
def test_on_a_pi_it_has_none_of_it(machine: str, python: str) -> None:
    default = asked_for(PROJECT["dependencies"], machine, python)
    assert not default & diagnosis(machine, python)
    assert {"gpiozero", "smbus2", "mcap", "typer"} <= default
    assert len(default) <= 13
