"""The button by which a recording of one's own is opened."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import events, ui

from deltactl.web.scripts import PICK_RECORDING, SEND


class OwnRecording:
    """Opens the browser's dialog, and says what became of the file."""

    def __init__(self, taken: Callable[[], None]):
        """taken: called after each file."""
        self._taken = taken
        place = ui.element("input").props('type=file accept=".csv,.gz,.mcap"').classes("hidden")
        place.props("data-testid=own-file")
        place.on("change", js_handler=SEND)
        place.on("told", self._told, args=["detail"])
        button = ui.button("Open a recording of yours", icon="upload_file")
        button.props("no-caps dense outline data-testid=own-recording").classes("px-2")
        button.on("click", js_handler=PICK_RECORDING)
        self._line = ui.label().classes("text-sm").props("data-testid=own-says")

    def tell(self, text: str) -> None:
        """Say something about the newest file."""
        self._line.set_text(text)

    def _told(self, event: events.GenericEventArguments) -> None:
        self.tell(str(event.args.get("detail", ""))[:400])
        self._taken()
