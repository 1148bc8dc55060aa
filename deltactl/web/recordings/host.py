"""The page as the tab of recordings knows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.web.behind.site import Site


class Host(Protocol):
    """`deltactl.web.page.RobotPage`, as far as this room needs it."""

    site: Site

    @property
    def operates(self) -> bool:
        """Whether whoever looks may command the robot."""

    def blame(self, components: list[str], found_in: str) -> None:
        """Colour the parts that a diagnosis names, and turn to the robot."""

    def show_tab(self, name: str) -> None:
        """Turn to another tab."""

    def edit(self, name: str, text: str, says: str = "") -> None:
        """Show a job in the editor."""

    def tell_home(self, seen: HomeSeen) -> None:
        """What the sensors said at home."""

    async def act(self, name: str, call: Callable[..., Any], *arguments: Any) -> Any:
        """Ask the daemon something; None when it refuses, which is shown."""
