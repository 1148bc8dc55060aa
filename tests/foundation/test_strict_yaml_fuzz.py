"""Whatever a file holds, the answer is a value or a ConfigError of one line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import Field

from deltactl.foundation import yaml_tree
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document, StrictModel

PATH = Path("any.yaml")


class Leaf(StrictModel):
    kind: Literal["leaf"]
    size_m: Annotated[float, Field(gt=0.0)] | tuple[float, float, float]


class Twig(StrictModel):
    kind: Literal["twig"]
    leaves: tuple[Leaf, ...] = ()
    names: dict[str, float | tuple[float, ...]] = Field(default_factory=dict)


class Tree(StrictModel):
    name: str
    top: Annotated[Leaf | Twig, Field(discriminator="kind")]
    count: Annotated[int, Field(ge=0, le=100)] = 1
    alive: bool = True
    note: str | None = None


def outcome(text: str) -> Tree | str:
    """The model, or the lines that refuse it, one a mistake."""
    try:
        return Document(PATH, text).check(Tree)
    except ConfigError as error:
        for line in error.args:
            assert line.startswith("any.yaml:")
            assert "\n" not in line
            assert len(line) < 1000
            line.encode()  # it can be printed
        return str(error)


@pytest.fixture(autouse=True, params=["CSafeLoader", "SafeLoader"], scope="module")
def parser(request: pytest.FixtureRequest) -> None:
    """PyYAML's parser in C and the one in Python, which stands in where it was built without."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(yaml_tree, "_LOADER", getattr(yaml, request.param))
        yield


keys = st.sampled_from(
    ["name", "top", "count", "alive", "note", "kind", "size_m", "leaves", "names", "nmae", "leaf"]
)
scalars = st.sampled_from(
    [
        "leaf",
        "twig",
        "1",
        "-2",
        "0.5",
        "5e-5",
        ".inf",
        ".nan",
        "1e999",
        "0x10",
        "yes",
        "~",
        "''",
        "'1'",
        "*a",
        "&a",
        "!!int",
        "!",
        "1:30",
        "2020-13-41",
        "<<",
        "=",
        "-",
        "?",
        "|",
        "99999999999999999999999999999999999999999",
    ]
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4).map(lambda items: f"[{', '.join(items)}]")
        | st.lists(st.tuples(keys, inner), max_size=4).map(
            lambda pairs: "{" + ", ".join(f"{key}: {value}" for key, value in pairs) + "}"
        )
    ),
    max_leaves=12,
)
files = st.lists(st.tuples(keys, values), max_size=6).map(
    lambda pairs: "".join(f"{key}: {value}\n" for key, value in pairs)
)


@settings(max_examples=80, deadline=None)
@given(st.text())
@example("a: !!timestamp foo")
@example("a: !!bool foo")
@example("a: !!int ''")
@example('a: "\\ud800"')
@example('"\\ud800": 1')
@example("a: \ud800")
@example("[" * 3000)
@example("{" * 3000)
@example("a: " * 3000)
@example("- " * 3000)
@example("%YAML 1.1\n---\n...\n---\n")
@example("? |\n  x\n  y\n: 1\n")
@example("a: 1\x85b: 2\u2028c: 3\n")
def test_any_text(text: str) -> None:
    outcome(text)


@pytest.mark.study
@settings(max_examples=80, deadline=None)
@given(files)
def test_anything_that_looks_like_a_file(text: str) -> None:
    outcome(text)


@settings(max_examples=80, deadline=None)
@given(st.text("ab:-?[]{},&*!|>'\"%@` \n\t#~.01e", max_size=60))
def test_the_letters_that_mean_something(text: str) -> None:
    outcome(text)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(1e-12, 1e12),
    st.integers(0, 100),
    st.text(st.characters(blacklist_categories=("Cs", "Cc", "Cf", "Zl", "Zp")), max_size=20).map(
        lambda text: f"a {text}"  # alone, 1e5 is text to PyYAML and a number here
    ),
)
def test_what_another_program_wrote_is_read_back(size_m: float, count: int, note: str) -> None:
    data = {
        "name": "x",
        "top": {"kind": "leaf", "size_m": size_m},
        "count": count,
        "note": note,
    }
    tree = outcome(yaml.safe_dump(data, allow_unicode=True))
    assert isinstance(tree, Tree), tree
    assert isinstance(tree.top, Leaf)
    assert tree.top.size_m == size_m
    assert (tree.count, tree.note) == (count, note)
