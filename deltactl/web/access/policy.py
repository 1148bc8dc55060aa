"""What the browser may load and run: a Content-Security-Policy with a nonce for each page.

NiceGUI writes its scripts and styles into the page without a nonce, and its scripts make elements
for more styles. Here its template gets the nonce of the request, and so does each style that a
script makes. An element or attribute that a foreign text smuggled in has none, and does not run.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import MutableMapping
from typing import Any, Final

from jinja2 import BaseLoader, Environment
from markupsafe import Markup
from nicegui import client

from deltactl.foundation.errors import ServiceError

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


def new_nonce(scope: MutableMapping[str, Any]) -> str:
    """A nonce for one answer, which the template finds in the request's scope."""
    nonce = secrets.token_urlsafe(16)
    scope[NONCE] = nonce
    return nonce


def policy(nonce: str) -> bytes:
    """The header's value.

    'unsafe-eval' is what NiceGUI needs: Vue compiles the templates of NiceGUI's components in the
    browser, and NiceGUI's script evaluates the calls that the server sends.
    """
    return (
        f"default-src 'none'; script-src 'self' 'nonce-{nonce}' 'unsafe-eval'; "
        f"style-src 'self' 'nonce-{nonce}'; img-src 'self' data: blob:; font-src 'self' data:; "
        "connect-src 'self'; worker-src 'self' blob:; manifest-src 'self'; "
        "frame-ancestors 'none'; form-action 'self'; base-uri 'none'; object-src 'none'"
    ).encode("ascii")


def with_nonce(html: str, nonce: str) -> Markup:
    """Our own HTML, with the nonce in each script and style."""
    return Markup(TAGS.sub(lambda tag: f'{tag.group()} nonce="{nonce}"', html))


def put_nonces_into_pages() -> None:
    """Have NiceGUI's template write the nonce. Raises ServiceError where it is another template."""
    environment = client.templates.env
    if isinstance(environment.loader, _Nonces):
        return
    assert environment.loader is not None
    environment.loader = _Nonces(environment.loader)
    environment.filters["with_nonce"] = with_nonce
    if environment.cache is not None:
        environment.cache.clear()
    environment.get_template("index.html")


class _Nonces(BaseLoader):
    """Loads templates from another loader."""

    def __init__(self, loader: BaseLoader):
        self._loader = loader

    def get_source(self, environment: Environment, template: str) -> tuple[str, str | None, Any]:
        text, path, fresh = self._loader.get_source(environment, template)
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
        styles = with_nonce(STYLES, f"{{{{ request.scope.{NONCE} }}}}")
        return text.replace("<head>", f"<head>\n{styles}", 1), path, fresh
