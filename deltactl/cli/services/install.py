"""`deltactl install` and `deltactl version`."""

from __future__ import annotations

import platform

from deltactl.cli.output import console, facts, print_json
from deltactl.firmware_py.controller.jobs.active_job import software_version


def install_service(robot: str | None, apply: bool) -> None:
    """Show, or do, what installing the service takes."""
    from deltactl.cli.robot.which_robot import robot_or_here
    from deltactl.firmware_py.install.install import install
    from deltactl.firmware_py.named_files import find

    install(find(robot_or_here(robot)), apply=apply)


def show_version(json_out: bool) -> None:
    """Versions that matter when asking for help."""
    import numpy

    from deltactl.models.network.runtime import runtime_names

    versions = {
        "deltactl": software_version(),
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "network runtime": runtime_names()[0],
        "machine": platform.machine(),
    }
    if json_out:
        print_json(versions)
    else:
        console.print(facts("deltactl", list(versions.items())))
