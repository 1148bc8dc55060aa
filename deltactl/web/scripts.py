"""All scripts of the page itself. The browser runs these and no other text (`access/policy.py`)."""

from __future__ import annotations

from typing import Final

from deltactl.web.behind.own_recordings import MAX_BYTES

WEBGL: Final = """<script>if (!document.createElement("canvas").getContext("webgl2"))
  document.documentElement.classList.add("without-webgl");</script>"""
"""Marks the page of a browser that cannot draw in 3D, where words stand instead."""

TURNED: Final = """(() => { window.scrollTo(0, 0);
setTimeout(() => window.dispatchEvent(new Event("resize")), 100); })()"""
"""A tab begins at its top; and the drawing, which has no size while it is hidden, finds its own."""

PICK_JOB: Final = "() => document.querySelector('.job-upload input[type=file]').click()"
PICK_RECORDING: Final = "() => document.querySelector('[data-testid=own-file]').click()"
"""In the browser itself, which opens its dialog for nothing but a click."""

SEND: Final = f"""async (event) => {{
  const field = event.target, file = field.files[0];
  const tell = (text) => field.dispatchEvent(new CustomEvent("told", {{detail: text}}));
  if (!file) return;
  if (file.size > {MAX_BYTES}) {{
    tell(file.name + ": more than {MAX_BYTES // 2**20} MB are not taken");
  }} else {{
    tell("sending " + file.name);
    try {{
      const answer = await fetch("/recording?name=" + encodeURIComponent(file.name),
                                 {{method: "POST", body: file}});
      tell((await answer.text()).trim());
    }} catch (error) {{ tell(file.name + ": could not be sent (" + error.message + ")"); }}
  }}
  field.value = "";
}}"""
"""The browser sends the file itself: through the page's connection it would block a stop."""

KNOWN: Final = (TURNED, PICK_JOB, PICK_RECORDING, SEND)
"""Expressions that NiceGUI has the browser evaluate."""
