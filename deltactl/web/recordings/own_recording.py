"""The button by which a recording of one's own is opened."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import events, ui

from deltactl.web.behind.own_recordings import MAX_BYTES

SEND = f"""async (event) => {{
  const file = event.target.files[0];
  if (!file) return;
  if (file.size > {MAX_BYTES}) {{
    emit(file.name + ": more than {MAX_BYTES // 2**20} MB are not taken");
  }} else {{
    emit("sending " + file.name);
    try {{
      const answer = await fetch("/recording?name=" + encodeURIComponent(file.name),
                                 {{method: "POST", body: file}});
      emit((await answer.text()).trim());
    }} catch (error) {{ emit(file.name + ": could not be sent (" + error.message + ")"); }}
  }}
  event.target.value = "";
}}"""
"""The browser sends the file itself: through the page's connection it would block a stop."""


PICK_FILE = "() => document.querySelector('[data-testid=own-file]').click()"


class OwnRecording:
    """Opens the browser's dialog, and says what became of the file."""

    def __init__(self, taken: Callable[[], None]):
        """taken: called after each file."""
        self._taken = taken
        place = ui.element("input").props('type=file accept=".csv,.gz,.mcap"').classes("hidden")
        place.props("data-testid=own-file")
        place.on("change", self._told, js_handler=SEND)
        button = ui.button("Open a recording of yours", icon="upload_file")
        button.props("no-caps dense outline data-testid=own-recording").classes("px-2")
        button.on("click", js_handler=PICK_FILE)
        self._line = ui.label().classes("text-sm").props("data-testid=own-says")

    def tell(self, text: str) -> None:
        """Say something about the newest file."""
        self._line.set_text(text)

    def _told(self, event: events.GenericEventArguments) -> None:
        self.tell(str(event.args)[:400])
        self._taken()
