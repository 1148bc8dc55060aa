"""What NiceGUI parses, or hands to the browser to run, is made of constants alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import deltactl.web
from deltactl.web.style import attribute

RUN = frozenset({
    "props", "style", "classes", "default_props", "default_style", "default_classes", "html",
    "markdown", "restructured_text", "mermaid", "add_css", "add_head_html", "add_body_html",
    "add_scss", "add_sass", "run_javascript", "add_slot", "html_content", "query", "teleport",
})  # fmt: skip
"""Calls whose text is parsed by NiceGUI or run by the browser."""
RUN_KEYWORDS = frozenset({"js_handler", "sanitize"})
HTML_CLASSES = frozenset({"HTMLResponse"})


def constant(value: ast.expr) -> bool:
    """A text from the source itself: written here, or a module's constant in capitals."""
    match value:
        case ast.Constant():
            return True
        case ast.Name(id=name):
            return name.isupper() or name in ("True", "False", "None")
        case ast.Subscript(value=ast.Name(id=name)):
            return name.isupper()
        case ast.BinOp(left=left, right=right, op=ast.Add()):
            return constant(left) and constant(right)
        case ast.IfExp(body=body, orelse=orelse):
            return constant(body) and constant(orelse)
    return False


def not_constant(source: str) -> Iterator[str]:
    """Calls that would have a text from elsewhere parsed or run."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        called = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        called = node.func.id if isinstance(node.func, ast.Name) else called
        given = [word.value for word in node.keywords if word.arg in RUN_KEYWORDS]
        if called in RUN:
            given += [*node.args, *(word.value for word in node.keywords)]
        if not all(constant(one) for one in given):
            yield f"line {node.lineno}: {ast.unparse(node)[:80]}"


def test_nothing_that_is_parsed_or_run_contains_a_text_from_elsewhere() -> None:
    folder = Path(deltactl.web.__file__).parent
    files = sorted(folder.rglob("*.py"))
    assert len(files) > 20
    found = [f"{file.name}, {one}" for file in files
             for one in not_constant(file.read_text(encoding="utf-8"))]  # fmt: skip
    assert not found, "use deltactl.web.style.attribute: " + "; ".join(found)


@pytest.mark.parametrize(
    "line",
    [
        """part.props(f'title="{name}"')""",
        """part.props('title="' + name + '"')""",
        """part.props('title="%s"' % name)""",
        """part.props("title={}".format(name))""",
        """part.props(name)""",
        """part.props(add=name)""",
        """part.style(f"width: {name}")""",
        """part.classes(replace=f"text-{name}")""",
        """ui.html(name)""",
        """part.on("click", js_handler=f"() => {name}")""",
        """ui.run_javascript("go(" + name + ")")""",
    ],
)
def test_the_check_finds_each_way_to_do_it(line: str) -> None:
    assert list(not_constant(line))


@pytest.mark.parametrize("name", [":title", "onclick", "on-click", 'x" y', "innerHTML"])
def test_an_attribute_that_would_be_run_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="no attribute for text"):
        attribute(None, name, "alert(1)")  # type: ignore[type-var]
