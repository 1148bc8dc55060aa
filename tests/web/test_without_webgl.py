"""What a browser sees that cannot draw in 3D."""

from __future__ import annotations

import re

from deltactl.web.page import STYLE, WEBGL


def test_the_mark_that_the_script_sets_shows_the_words_and_hides_the_empty_box() -> None:
    found = re.search(r'classList\.add\("([\w-]+)"\)', WEBGL)
    assert found
    rules = dict(re.findall(r"([^{}]+)\{([^{}]*)\}", STYLE))
    applied = {selector.strip(): rule for selector, rule in rules.items() if found[1] in selector}
    assert "display: block" in applied[f".{found[1]} .no-webgl"]
    (hidden,) = (selector for selector, rule in applied.items() if "display: none" in rule)
    assert f".{found[1]} .scene-box" in hidden
    assert "display: none" in next(
        rule for selector, rule in rules.items() if selector.strip() == ".no-webgl"
    )
