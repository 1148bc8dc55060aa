"""What the browser may load and run: a Content-Security-Policy with a nonce for each page.

NiceGUI writes its scripts and styles into the page without a nonce, and its scripts make elements
for more styles. Here its template gets the nonce of the request, and so does each style that a
script makes. An element or attribute that a foreign text smuggled in has none, and does not run.
"""

from __future__ import annotations

import json
import logging
import re
import secrets
from collections.abc import MutableMapping, Sequence
from pathlib import Path
from typing import Any, Final

from jinja2 import BaseLoader, Environment
from markupsafe import Markup
from nicegui import __version__, client

from deltactl.foundation.errors import ServiceError

FOLDER: Final = Path(__file__).parent
TEMPLATES: Final = FOLDER / "compiled_templates.js"
"""Written by `python -m tests.web.compile_templates`; its first line names the NiceGUI."""
STRICT: Final = TEMPLATES.read_text(encoding="utf-8").startswith(f"// NiceGUI {__version__}\n")
"""Whether the page does without 'unsafe-eval'.

NiceGUI needs that: Vue compiles the templates of NiceGUI's components in the browser, and NiceGUI's
script evaluates handlers of events and the calls that the server sends. For the version that is
pinned the templates are compiled beforehand, and `without_eval.js` takes the calls apart."""
NONCE: Final = "deltactl_nonce"
"""Under this key of the request's scope."""
TAGS: Final = re.compile(r"<(script|style)(?=[\s>])")
STYLES: Final = """<script>{
  const nonce = document.currentScript.nonce, make = Document.prototype.createElement;
  Document.prototype.createElement = function (...named) {
    const made = make.apply(this, named);
    if (made.localName === "style") made.nonce = nonce;
    return made;
  };
}</script>
"""
"""Tailwind, Quasar and the editor write their styles when they run."""
_log = logging.getLogger(__name__)


def new_nonce(scope: MutableMapping[str, Any]) -> str:
    """A nonce for one answer, which the template finds in the request's scope."""
    nonce = secrets.token_urlsafe(16)
    scope[NONCE] = nonce
    return nonce


def policy(nonce: str) -> bytes:
    """The header's value."""
    evaluates = "" if STRICT else " 'unsafe-eval'"
    return (
        f"default-src 'none'; script-src 'self' 'nonce-{nonce}'{evaluates}; "
        f"style-src 'self' 'nonce-{nonce}'; img-src 'self' data: blob:; font-src 'self' data:; "
        "connect-src 'self'; worker-src 'self' blob:; manifest-src 'self'; "
        "frame-ancestors 'none'; form-action 'self'; base-uri 'none'; object-src 'none'"
    ).encode("ascii")


def with_nonce(html: str, nonce: str) -> Markup:
    """Our own HTML, with the nonce in each script and style."""
    return Markup(TAGS.sub(lambda tag: f'{tag.group()} nonce="{nonce}"', html))


def put_into_pages(known: Sequence[str]) -> None:
    """Have NiceGUI's template write the nonce, and let the browser run the `known` scripts.

    Raises ServiceError where it is another template.
    """
    if not STRICT:
        _log.warning(
            "the page's scripts are compiled for another NiceGUI than %s: browsers are allowed"
            " to evaluate texts; install the version that constraints.txt names",
            __version__,
        )
    environment = client.templates.env
    if isinstance(environment.loader, _Nonces):
        return
    assert environment.loader is not None
    environment.loader = _Nonces(environment.loader, _first_scripts(known))
    environment.filters["with_nonce"] = with_nonce
    if environment.cache is not None:
        environment.cache.clear()
    environment.get_template("index.html")


def _first_scripts(known: Sequence[str]) -> str:
    """What runs before all other scripts."""
    if not STRICT:
        return STYLES
    knows = "".join(
        f"deltactlScripts.set({json.dumps(script)}, () => ({script}));\n" for script in known
    )
    text = (FOLDER / "without_eval.js").read_text(encoding="utf-8")
    compiled = TEMPLATES.read_text(encoding="utf-8")
    # Raw: the scripts contain what Jinja would take for its own.
    return STYLES + "<script>{% raw %}" + text + knows + compiled + "{% endraw %}</script>\n"


class _Nonces(BaseLoader):
    """Loads templates from another loader, with scripts before all others."""

    def __init__(self, loader: BaseLoader, first: str):
        self._loader, self._first = loader, first

    def get_source(self, environment: Environment, template: str) -> tuple[str, str | None, Any]:
        text, path, fresh = self._loader.get_source(environment, template)
        text = text.replace("<head>", f"<head>\n{self._first}", 1)
        text = TAGS.sub(rf'\g<0> nonce="{{{{ request.scope.{NONCE} }}}}"', text)
        text = text.replace(' style="display: none"', " hidden")
        for name in ("head_html", "body_html"):
            before = f"{{{{ {name} | safe }}}}"
            if before not in text:
                raise ServiceError(
                    f"NiceGUI's template has no {before}; install the version pinned"
                )
            after = f"{{{{ {name} | with_nonce(request.scope.{NONCE}) }}}}"
            text = text.replace(before, after)
        return text, path, fresh
