"""`deltactl network reproduce uzunovic-2013`: sections 3 (kinematics) and 5 (control)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from deltactl.charts.page import HINT, page, paragraph
from deltactl.reproduction.outcome import Outcome, Sheet, check_writable, write
from deltactl.reproduction.uzunovic_2013.control import ControlPart, reproduce_control
from deltactl.reproduction.uzunovic_2013.kinematics import KinematicsPart, reproduce_kinematics

TITLE = "Uzunovic 2013 over again"
LEAD = (
    "Uzunovic, Golubovic, Baran and Sabanovic, ELECO 2013: a micro delta whose inverse kinematics "
    "is a 3-25-3 network, under acceleration control with a disturbance observer."
)


def reproduce(folder: Path, quick: bool, say: Callable[[str], None]) -> Outcome:
    """Both parts. Raises RecordingError when nothing can be written."""

    def tell(done: int, total: int, text: str) -> None:
        if text:
            say(f"{done} of {total}: {text}")

    check_writable(folder)
    say("section 3: kinematics")
    kinematics = reproduce_kinematics(quick, tell)
    say("section 5: control")
    control = reproduce_control(None, quick, tell)
    sheets = [*kinematics.sheets, *control.sheets]
    command = f"deltactl network reproduce uzunovic-2013{' --quick' if quick else ''}"
    return write(folder, sheets, _html(kinematics, control), _markdown(sheets, command))


def _html(kinematics: KinematicsPart, control: ControlPart) -> str:
    return page(TITLE, [paragraph(HINT, "note howto"), *kinematics.html(), *control.html()], LEAD)


def _markdown(sheets: list[Sheet], command: str) -> str:
    parts = [f"Printed by `{command}`.", *(sheet.markdown() for sheet in sheets)]
    return "\n\n".join(parts) + "\n"
