"""What a mistake in a file is answered with: one line with file, line, key and a way out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from pydantic import Field, model_validator

from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.foundation.strict_yaml import Document, StrictModel, load

Length = Annotated[float, Field(gt=0.0)]


class Round(StrictModel):
    shape: Literal["round"]
    radius_m: Annotated[float, Field(gt=0.0, le=2.0)]


class Square(StrictModel):
    shape: Literal["square"]
    side_m: float
    corners: tuple[int, int] = (0, 1)


class Part(StrictModel):
    length_m: float
    ends: tuple[float, float] = (0.0, 1.0)

    @model_validator(mode="after")
    def _ordered(self) -> Part:
        if self.ends[0] >= self.ends[1]:
            raise ValueError("ends must be [lowest, highest]")
        return self


class Plan(StrictModel):
    name: str
    outline: Annotated[Round | Square, Field(discriminator="shape")]
    period_s: float = 1.0
    count: Annotated[int, Field(ge=1)] = 1
    fast: bool = False
    note: str | None = None
    parts: tuple[Part, ...] = ()
    size_m: Length | tuple[Length, Length, Length] = 1.0


GOOD = """\
name: test
outline:
  shape: round
  radius_m: 0.5
"""
PATH = Path("plan.yaml")


def check(text: str) -> Plan:
    return Document(PATH, text).check(Plan)


def test_lengths_in_mm_are_one_mistake_beside_the_others() -> None:
    text = GOOD.replace("radius_m: 0.5", "radius_m: 500") + "count: 0\n"
    with pytest.raises(ConfigError) as caught:
        check(text)
    assert set(str(caught.value).splitlines()) == {
        "plan.yaml:4: outline.radius_m: this is in metres, not in mm: write 0.5",
        "plan.yaml:5: count: Input should be greater than or equal to 1 (got 0)",
    }


def test_a_good_file() -> None:
    plan = check(
        GOOD + "count: 3\nparts:\n  - {length_m: 1}\n  - length_m: 2.5\n    ends: [1, 2]\n"
    )
    assert plan.outline == Round(shape="round", radius_m=0.5)
    assert plan.count == 3
    assert [part.length_m for part in plan.parts] == [1.0, 2.5]
    assert plan.parts[1].ends == (1.0, 2.0)


@pytest.mark.parametrize(
    ("added", "message"),
    [
        ("perod_s: 2.0\n", "plan.yaml:5: perod_s: unknown key; did you mean 'period_s'?"),
        ("size_m: [1, 2]\n", "plan.yaml:5: size_m: item 3 is missing"),
        ("size_m: [1, 2, -3]\n",
         "plan.yaml:5: size_m.2: Input should be greater than 0 (got -3)"),
        ("size_m: wide\n", "plan.yaml:5: size_m: Input should be a valid number (got 'wide')"),
        ("size_m: -1\n", "plan.yaml:5: size_m: Input should be greater than 0 (got -1)"),
        (
            "zzz: 2.0\n",
            "plan.yaml:5: zzz: unknown key; valid keys:"
            " count, fast, name, note, outline, parts, period_s, size_m",
        ),
        ("count: 1\nname: again\n", "plan.yaml:6: 'name' occurs here twice; remove one"),
        ("period_s: .nan\n", "plan.yaml:5: period_s: must be a finite number, not nan"),
        ("period_s: -.inf\n", "plan.yaml:5: period_s: must be a finite number, not -inf"),
        ("period_s: 1e999\n", "plan.yaml:5: period_s: must be a finite number, not inf"),
        (
            "period_s: fast\n",
            "plan.yaml:5: period_s: Input should be a valid number (got 'fast')",
        ),
        ("period_s: '1'\n", "plan.yaml:5: period_s: Input should be a valid number (got '1')"),
        (
            "period_s: 20 ms\n",
            "plan.yaml:5: period_s: Input should be a valid number (got '20 ms'); write it in"
            " seconds and without the unit, 0.02",
        ),
        ("count: 2.5\n", "plan.yaml:5: count: Input should be a valid integer (got 2.5)"),
        ("count: true\n", "plan.yaml:5: count: Input should be a valid integer (got True)"),
        ("count: 010\n", "plan.yaml:5: count: Input should be a valid integer (got '010')"),
        ("count: 0\n", "plan.yaml:5: count: Input should be greater than or equal to 1 (got 0)"),
        ("fast: 1\n", "plan.yaml:5: fast: Input should be a valid boolean (got 1)"),
        ("note: 5\n", "plan.yaml:5: note: Input should be a valid string (got 5)"),
        ("parts: 5\n", "plan.yaml:5: parts: Input should be a valid array (got 5)"),
        ("parts:\n  - length_m: 1\n    ends: [2, 1]\n",
         "plan.yaml:6: parts.0: ends must be [lowest, highest]"),
        ("parts:\n  - length_m: 1\n  - {}\n", "plan.yaml:7: parts.1: 'length_m' is missing"),
        ("parts:\n  - length_m: 1\n    lenght_m: 1\n",
         "plan.yaml:7: parts.0.lenght_m: unknown key; did you mean 'length_m'?"),
        ("parts:\n  - length_m: 1\n    ends:\n     - 1\n     - x\n",
         "plan.yaml:9: parts.0.ends.1: Input should be a valid number (got 'x')"),
        ("note: &n x\n", "plan.yaml:5: anchors and aliases (& and *) are not taken; write 'n' out"),
        ("note: *n\n", "plan.yaml:5: anchors and aliases (& and *) are not taken; write 'n' out"),
        ("note: !secret x\n", "plan.yaml:5: tags (!) are not taken; remove '!secret'"),
        ("'a\\nb': 1\n? [1, 2]\n: 3\n", "plan.yaml:6: a key must be a plain word"),
        ('"a\\nb": 1\n', "plan.yaml:5: a key must be a plain word, not 'a\\nb'"),
        ('"": 1\n', "plan.yaml:5: a key must be a plain word, not ''"),
        (": 1\n", None),
        ('note: "\\ud800"\n', None),
        ("note: 'open\n", None),
        ("\tnote: 1\n", None),
        ("---\nnote: 1\n", "plan.yaml:5: a second document begins here ('---'); remove it"),
        ("count: " + "9" * 5000 + "\n",
         "plan.yaml:5: a number of 5000 digits; nothing here is that large"),
        ("note: " + "[" * 5000 + "\n", "plan.yaml:5: nested more than 20 deep"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(added: str, message: str | None) -> None:
    with pytest.raises(ConfigError) as caught:
        check(GOOD + added)
    if message is None:  # the words are the YAML parser's
        assert str(caught.value).startswith("plan.yaml:")
        assert "\n" not in str(caught.value)
    else:
        assert str(caught.value) == message


@pytest.mark.parametrize(
    ("outline", "message"),
    [
        ("{radius_m: 1}", "plan.yaml:2: outline: 'shape' is missing"),
        ("{shape: round}", "plan.yaml:2: outline: 'radius_m' is missing"),
        (
            "{shape: round, radius: 1}",
            "plan.yaml:2: outline.radius: unknown key; did you mean 'radius_m'?",
        ),
        (
            "{shape: square, side_m: 1, radius_m: 1}",
            "plan.yaml:2: outline.radius_m: unknown key here; it belongs to shape round",
        ),
        (
            "{shape: round, radius_m: 3}",
            "plan.yaml:2: outline.radius_m: Input should be less than or equal to 2 (got 3)",
        ),
    ],
)
def test_mistakes_inside_a_choice(outline: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        check(f"name: test\noutline: {outline}\n")
    assert str(caught.value) == message


def test_a_wrong_choice_names_the_right_ones() -> None:
    with pytest.raises(ConfigError) as caught:
        check("name: test\noutline:\n  radius_m: 1\n  shape: oval\n")
    assert str(caught.value) == (
        "plan.yaml:4: outline.shape: must be one of round, square (got 'oval')"
    )


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5e-5", 5e-5), ("-5E+4", -5e4), ("1e3", 1000.0), (".5", 0.5), ("1.", 1.0),
        ("1_000.5", 1000.5), ("12", 12), ("-3", -3), ("+3", 3), ("0", 0), ("0x29", 41),
        ("1_000", 1000), ("010", "010"), ("1:30", "1:30"), ("2024-01-31", "2024-01-31"),
        ("true", True), ("no", False), ("~", None), ("", None), ("null", None),
        ("'5'", "5"), ('"true"', "true"), ("=", "="), ("nan", "nan"),
        ("0b1", "0b1"), ("1__0", "1__0"), ("5e", "5e"),
    ],
)  # fmt: skip
def test_plain_scalars_are_what_they_look_like(text: str, value: Any) -> None:
    found = Document(PATH, f"a: {text}\n").data["a"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize("text", ["", "# nothing\n", "just words\n", "- a\n- b\n", "5\n"])
def test_a_file_must_be_keys_and_values(text: str) -> None:
    with pytest.raises(ConfigError, match=r"^plan\.yaml:1: must be a list of 'key: value' lines$"):
        Document(PATH, text)


def test_aliases_cannot_blow_up() -> None:
    lines = ["a0: &a0 [lol, lol, lol, lol, lol, lol, lol, lol, lol]"]
    for level in range(1, 12):
        inner = ", ".join([f"*a{level - 1}"] * 9)
        lines.append(f"a{level}: &a{level} [{inner}]")
    with pytest.raises(ConfigError, match=r"^plan\.yaml:1: anchors and aliases"):
        Document(PATH, "\n".join(lines))


def test_lines_of_keys_and_items() -> None:
    document = Document(PATH, "a:\n  - b: 1\n\n    c:\n      - 2\n# word\nd: {e: 3}\n")
    assert document.line_of(("a",)) == 1
    assert document.line_of(("a", 0, "b")) == 2
    assert document.line_of(("a", 0, "c", 0)) == 5
    assert document.line_of(("d", "e")) == 7
    assert document.line_of(("d", "e", "nowhere")) == 7
    assert document.line_of(("nowhere",)) == 1
    assert str(document.fail(("d", "e"), "is odd")) == "plan.yaml:7: d.e: is odd"


def test_a_long_wrong_value_is_cut() -> None:
    with pytest.raises(ConfigError) as caught:
        check(GOOD + f"period_s: {'x' * 5000}\n")
    assert len(str(caught.value)) < 200


def test_reading_files(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    path.write_text("\ufeff" + GOOD, encoding="utf-8")  # as Windows editors write it
    assert load(path, Plan).name == "test"
    path.write_bytes(b"name: \xff\xfe\n")
    with pytest.raises(ConfigError, match=r"plan\.yaml: is not a text file in UTF-8$"):
        load(path, Plan)


@pytest.mark.parametrize("name", ["absent.yaml", ".", "a\0b", "plan.yaml/x", "x" * 5000])
def test_unreadable_files(tmp_path: Path, name: str) -> None:
    (tmp_path / "plan.yaml").write_text(GOOD)
    with pytest.raises(MissingFile) as caught:
        load(tmp_path / name, Plan)
    assert isinstance(caught.value, FileNotFoundError)
    assert "\n" not in str(caught.value)


def test_a_file_without_end_is_refused() -> None:
    endless = Path("/dev/zero")
    if not endless.exists():
        pytest.skip("no /dev/zero here")
    with pytest.raises(ConfigError, match="is no plain file"):
        Document.read(endless)
