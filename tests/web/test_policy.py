"""What the browser refuses to run on the page, whatever got into it."""

from __future__ import annotations

import time
import urllib.request

import pytest

from deltactl.web.access.policy import STRICT, TEMPLATES, with_nonce
from tests.web.compile_templates import compiled
from tests.web.conftest import Browser, WebPage, a_chromium

SMUGGLED = {
    "a script": "const s = document.createElement('script'); s.textContent = 'window.__t=1';"
    " document.body.append(s)",
    "a handler": "document.body.insertAdjacentHTML('beforeend', '<img src=q "
    "onerror=window.__t=1>')",
    "an address": "const a = document.createElement('a'); a.href = 'javascript:window.__t=1';"
    " document.body.append(a); a.click()",
    "a frame": "const f = document.createElement('iframe'); f.srcdoc ="
    " '<script>parent.__t=1</script>'; document.body.append(f)",
    "a timer": "setTimeout('window.__t=1', 0)",
    "another's script": "const s = document.createElement('script'); s.src ="
    " 'data:text/javascript,window.__t=1'; document.body.append(s)",
}


def after(browser: Browser, script: str) -> object:
    """What a script of the page's own would leave, as one that came over its connection."""
    # Later: while chromedriver's own script runs, the browser lets everything be evaluated.
    later = with_quotes(f"setTimeout(() => {{ {script} }}, 50)")
    nonced = (
        "{ const s = document.createElement('script');"
        "s.nonce = document.querySelector('script[nonce]').nonce;"
        f"s.textContent = {later}; document.body.append(s) }}"
    )
    browser.driver.execute_script(nonced)
    time.sleep(0.3)
    return browser.driver.execute_script("return [window.__t, window.__refused]")


def with_quotes(script: str) -> str:
    return "`" + script.replace("`", "\\`").replace("</script>", "<\\/script>") + "`"


@pytest.mark.parametrize("what", sorted(SMUGGLED))
def test_what_is_smuggled_in_does_not_run(browser: Browser, what: str) -> None:
    assert after(browser, "window.__t = 7") == [7, None], "a script with the nonce runs"
    assert after(browser, f"delete window.__t; {SMUGGLED[what]}") == [None, None]


@pytest.mark.parametrize(
    "code",
    [
        "eval('window.__t=1')",
        "new Function('window.__t=1')()",
        "Function('Vue', 'window.__t=1')()",
        "(async () => {}).constructor('window.__t=1')()",
        # What would be run as a property of an element, and as a call of NiceGUI.
        "eval('return runMethod(1, \"x\", [window.__t=1])')",
    ],
)
def test_no_text_is_evaluated(browser: Browser, code: str) -> None:
    told = f"delete window.__t; try {{ {code} }} catch (error) {{ window.__refused = error.name }}"
    ran, refused = after(browser, told)  # type: ignore[misc]
    assert ran is None
    assert refused in ("EvalError", "SyntaxError")


def test_the_answers_say_so(simulated: WebPage) -> None:
    assert STRICT
    for path in ("/", "/health"):
        with urllib.request.urlopen(simulated.url + path, timeout=20.0) as answer:
            said = answer.headers["Content-Security-Policy"]
            assert "unsafe" not in said
            assert "nonce-" in said
    with (
        urllib.request.urlopen(simulated.url, timeout=20.0) as one,
        urllib.request.urlopen(simulated.url, timeout=20.0) as other,
    ):
        assert one.headers["Content-Security-Policy"] != other.headers["Content-Security-Policy"]


def test_the_templates_are_those_of_this_nicegui(simulated: WebPage) -> None:
    """Otherwise: python -m tests.web.compile_templates."""
    driver = a_chromium()
    try:
        assert compiled(driver, simulated.url) == TEMPLATES.read_text(encoding="utf-8")
    finally:
        driver.quit()


def test_a_style_that_a_script_makes_is_in_force(browser: Browser) -> None:
    """Tailwind, Quasar and the editor make their own, and all of them have to look as they do."""
    size = "const s = document.createElement('style'); s.textContent = 'body { --seen: 1 }';"
    after(browser, f"{size} document.head.append(s)")
    seen = "return getComputedStyle(document.body).getPropertyValue('--seen').trim()"
    assert browser.driver.execute_script(seen) == "1"


def test_only_scripts_and_styles_get_a_nonce() -> None:
    text = "<script>a</script><style >b</style><scripted><p>"
    wanted = '<script nonce="n">a</script><style nonce="n" >b</style><scripted><p>'
    assert str(with_nonce(text, "n")) == wanted
