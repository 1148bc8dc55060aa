"""Writes `deltactl/web/access/compiled_templates.js`: NiceGUI's templates as Vue compiles them.

python -m tests.web.compile_templates
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nicegui
from selenium import webdriver

from deltactl.web.access.policy import TEMPLATES

ELEMENTS = Path(nicegui.__file__).parent / "elements"
USED = ("codemirror/codemirror", "expansion", "header", "input", "link", "scene/scene", "select",
        "upload")  # fmt: skip
"""Components of the page that have a template."""
TEXT = re.compile(r"^  template: `(.*?)`,$", re.DOTALL | re.MULTILINE)
COMPILE = """
const done = arguments[arguments.length - 1], texts = arguments[0], codes = [];
import(arguments[1]).then((Vue) => {
  const plain = window.Function;
  window.Function = new Proxy(plain, {
    apply: (target, self, given) => { codes.push(given.at(-1)); return plain(...given); },
    construct: (target, given) => { codes.push(given.at(-1)); return new plain(...given); },
  });
  texts.forEach((text) => Vue.compile(text));
  window.Function = plain;
  done(codes);
}, (error) => done(String(error)));
"""


def templates() -> Iterator[str]:
    """The texts in NiceGUI's files."""
    for name in USED:
        (text,) = TEXT.findall((ELEMENTS / f"{name}.js").read_text(encoding="utf-8"))
        assert "${" not in text
        assert "\\" not in text
        yield text


def compiled(driver: webdriver.Chrome, url: str) -> str:
    """The file's text, by a browser at a page that NiceGUI serves."""
    vue = f"/_nicegui/{nicegui.__version__}/static/vue.esm-browser.prod.js"
    driver.execute_cdp_cmd("Page.setBypassCSP", {"enabled": True})
    driver.get(f"{url}/health")
    codes: Any = driver.execute_async_script(COMPILE, list(templates()), vue)
    assert isinstance(codes, list), codes
    entries = "".join(
        f"deltactlTemplates.set({json.dumps(code)}, function (Vue) {{\n{code}\n}});\n"
        for code in codes
    )
    return f"// NiceGUI {nicegui.__version__}\n{entries}"


if __name__ == "__main__":
    import tempfile

    from tests.web.conftest import a_chromium, end_page, start_page

    with tempfile.TemporaryDirectory() as folder:
        page = start_page(Path(folder))
        browser = a_chromium()
        try:
            TEMPLATES.write_text(compiled(browser, page.url), encoding="utf-8")
        finally:
            browser.quit()
            end_page(page)
