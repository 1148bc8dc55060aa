"""What the browser is given beside elements: styles, scripts, and attributes with texts in them."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final, TypeVar

from nicegui import ui

from deltactl.web.behind.own_recordings import MAX_BYTES

STYLE = """
.stop-button { position: fixed; top: 4px; right: 8px; z-index: 9900; min-width: 7rem;
  font-size: 1.15rem; font-weight: 800; height: 42px; box-shadow: 0 0 0 2px white; }
.stop-room { min-width: 7.5rem; }
.latch { z-index: 1500; background: #b91c1c; color: white; padding: 8px 12px; border-radius: 6px;
  position: sticky; top: 52px; }
.news { background: #fef3c7; color: #78350f; padding: 8px 12px; border-radius: 6px; }
.scene-box { height: min(56vh, 520px); min-height: 260px; }
.editor { height: max(24rem, 100vh - 130px); }
.no-webgl { display: none; color: #78350f; } .without-webgl .no-webgl { display: block; }
.without-webgl .scene-box, .without-webgl .scene-caption { display: none; }
.figures { font-variant-numeric: tabular-nums; }
.bg-off { background: #e0e0e0; } .text-off-text { color: #616161; }
.q-btn.disabled { outline: 1px dashed #94a3b8; outline-offset: -1px; box-shadow: none; }
.q-btn.disabled::before { border-color: transparent; box-shadow: none; }
.jog .q-btn { min-width: 46px; min-height: 42px; }
.jog-cross { display: grid; grid-template-columns: repeat(3, 52px) 64px; gap: 6px; padding: 6px;
  justify-items: stretch; border-radius: 8px; width: max-content; }
.jog-cross > :nth-child(4n) { margin-left: 12px; }
.jog .q-btn--outline { background: rgba(148, 163, 184, 0.14); }
.jog-cross:focus-within { outline: 2px solid #3b82f6; }
.plots { height: 470px; } .mistake { background: rgba(220, 38, 38, 0.22); }
.preview { height: auto; aspect-ratio: 2.1; max-width: 640px; }
.recording > :empty { display: none; }
.history { display: grid; gap: 2px 14px; overflow-wrap: anywhere;
  grid-template-columns: minmax(0, 1fr) auto minmax(0, 1fr) auto auto; }
.history > :not(:nth-child(5n + 1), :nth-child(5n + 3)) { white-space: nowrap; }
.console { font-family: monospace; font-size: 12px; max-height: 70vh; overflow-y: auto; }
.log-line { white-space: pre-wrap; overflow-wrap: anywhere; }
.log-line[data-level="warning"] { color: #b45309; }
.log-line[data-level="error"], .log-line[data-level="critical"] { color: #b91c1c; }
@media (hover: none) and (pointer: coarse) { .with-keys { display: none; } }
@media (max-width: 599px) { .q-header .q-tab { padding: 0 7px; }
  .scene-box { height: 36vh; min-height: 220px; }
  .editor { height: 24rem; } .history { gap: 4px 8px; font-size: 12px; }
  .stop-button { top: auto; bottom: 0; left: 0; right: 0; height: 60px; border-radius: 0; }
  .q-notifications__list--bottom { bottom: 64px; }
  .stop-room { min-width: 0; } .q-page-container { padding-bottom: 84px; }
  .nicegui-content { padding: 4px; padding-bottom: 90px; } }
"""

DARK = """
.body--dark .text-gray-600 { color: #94a3b8; } .body--dark .text-red-800 { color: #fca5a5; }
.body--dark .text-green-800 { color: #86efac; } .body--dark a { color: #93c5fd; }
.body--dark .no-webgl, .body--dark .log-line[data-level="warning"] { color: #fcd34d; }
.body--dark .log-line[data-level="error"] { color: #fca5a5; }
.body--dark .q-btn--outline, .body--dark .q-tab-panel .q-btn--flat { --q-primary: #93c5fd; }
.body--dark .bg-off { background: #2b3442; } .body--dark .text-off-text { color: #a3adba; }
.body--dark .q-tab-panels, .body--dark .q-tab-panel { background: none; }
.body--dark .scene-box, .body--dark .editor { filter: invert(0.9) hue-rotate(180deg); }
"""
"""Where the browser asks for it. The drawing and the editor know bright colours only: turned over,
and then each hue turned back."""

PAPER = """
@media print { .stop-button, .q-tabs, .q-btn, .q-card.jog,
  .q-card.hidden-fault, .stop-room { display: none !important; }
  .q-header { position: static; background: none !important; color: black; padding: 0; }
  .q-page-container { padding: 0 !important; } .latch { position: static; }
  .q-badge, .latch, .q-linear-progress, .news { print-color-adjust: exact; }
  .q-tab-panels, .q-panel, .q-tab-panel { overflow: visible !important; display: block; }
  .scene-box { zoom: 0.8; } .q-tab-panel > .row { display: block; }
  .q-tab-panel > .row > * + * { margin-top: 8px; }
  .q-card { box-shadow: none; border: 1px solid #cbd5e1; break-inside: avoid; }
  .editor, .editor .cm-editor, .editor .cm-scroller { height: auto !important; overflow: visible; }
  body.body--dark { background: white !important; color: black !important; }
  .body--dark .q-card { background: white; color: black; }
  .body--dark .scene-box, .body--dark .editor { filter: none; } }
"""
"""What can only be pressed stays off the paper."""


WEBGL: Final = """<script>{
  const gl = document.createElement("canvas").getContext("webgl2");
  const drawer = gl?.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL;
  if (!gl) document.documentElement.classList.add("without-webgl");
  if (drawer && /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(drawer))) {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, given) {
      return get.call(this, kind, kind === "2d" ? given : { ...given, antialias: false });
    };
  }
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
}</script>"""
"""Marks the page of a browser that cannot draw in 3D, where text replaces the drawing. Where the
processor draws in place of a graphics chip, smooth edges would cost as much as the drawing."""

APP: Final = """<link rel="manifest" href="/manifest.webmanifest">
<link rel="apple-touch-icon" href="/icon-192.png"><meta name="theme-color" content="#1e293b">
<meta name="mobile-web-app-capable" content="yes">"""
"""By which a phone offers to install the page."""

TURNED: Final = """(() => { window.scrollTo(0, 0);
setTimeout(() => window.dispatchEvent(new Event("resize")), 100); })()"""
"""A tab begins at its top; and the drawing, which has no size while it is hidden, finds its own."""

PICK_JOB: Final = "() => document.querySelector('.job-upload input[type=file]').click()"
PICK_RECORDING: Final = "() => document.querySelector('[data-testid=own-file]').click()"
"""In the browser itself, which opens its dialog for nothing but a click."""

SEND: Final = f"""async (event) => {{
  const field = event.target, file = field.files[0];
  const tell = (text) => field.dispatchEvent(new CustomEvent("message", {{detail: text}}));
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

KEEP_KEYS: Final = """(event) => {
  if (/^(Arrow|Page)/.test(event.key)) event.preventDefault();
}"""
"""Keys that jog do not scroll the page."""

PAINTED: Final = "new Promise((seen) => requestAnimationFrame(() => setTimeout(seen, 0)))"
"""Answered once the browser has painted all that was sent before."""

QUIET: Final = """() => document.querySelectorAll(".nicegui-scene").forEach((place) => {
  const renderer = getElement(place)?.renderer;
  if (!renderer || renderer.quiet) return;
  const { render, setSize } = renderer;
  let before = [];
  renderer.quiet = true;
  renderer.setSize = (...size) => { before = []; setSize.apply(renderer, size); };
  renderer.render = (scene, camera) => {
    const now = [...camera.position, ...camera.quaternion, camera.aspect];
    scene.traverse((part) => now.push(part.visible, ...part.position, ...part.quaternion,
      ...part.scale, part.material?.opacity, part.material?.color?.getHex()));
    const same = (one, at) => one === before[at] || Math.abs(one - before[at]) < 1e-6;
    if ((now.length === before.length && now.every(same)) || !place.offsetParent) return;
    before = now;
    render.call(renderer, scene, camera);
  };
})"""
"""NiceGUI draws a scene twenty times a second, also one that is hidden or where nothing moves.
This leaves out each picture that is the one before: a phone's battery, and on a computer without
graphics all of its time."""

KNOWN: Final = (TURNED, PICK_JOB, PICK_RECORDING, SEND, KEEP_KEYS, PAINTED, QUIET)
"""Expressions that NiceGUI has the browser evaluate."""

PAINT_S: Final = 2.0


async def painted() -> None:
    """Wait until the browser has painted what was sent; of one that does not answer, 2 s.

    Without it a slow browser is sent more than it can show, and shows what was long ago.
    """
    with suppress(TimeoutError):
        await ui.run_javascript(PAINTED, timeout=PAINT_S)


Part = TypeVar("Part", bound=ui.element)
TEXTS = re.compile(r"(aria|data)-[a-z-]+|alt|color|label|placeholder|title")
"""Attributes that the browser takes as text. A handler of an event, an address or a style is none,
and no name that begins with a colon."""


def attribute(part: Part, name: str, value: str | int | float | None) -> Part:
    """Set one attribute to a value as it is; None removes it.

    Raises ValueError for a name of which a browser could run the value.
    """
    if not TEXTS.fullmatch(name):
        raise ValueError(f"{name!r} is no attribute for text; see TEXTS")
    props: Any = part.props
    if props.get(name) != value:
        props.set_optional(name, value)
    return part


def marked(part: Part, mark: str) -> Part:
    """Give an element the name by which tests and scripts find it."""
    return attribute(part, "data-testid", mark)


def labelled(part: Part, text: str) -> Part:
    """Say to screen readers what an element is."""
    return attribute(part, "aria-label", text)


def small(says: str, icon: str, call: Callable[[], Any], mark: str) -> ui.button:
    """A round button with an icon alone; a title, as a tooltip would stay on a touch screen."""
    button = ui.button(icon=icon, on_click=call).props("flat dense round size=sm")
    return marked(attribute(labelled(button, says), "title", says), mark)


def tell_problem(text: str) -> None:
    """One line in red, until it is closed."""
    close = {"label": "Close", "color": "white"}
    ui.notify(text, type="negative", multi_line=True, timeout=12_000, actions=[close])
