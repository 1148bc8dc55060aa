"""Answers in words: those of the JSON, with its numbers, in a bounded length.

A number is printed as the JSON has it, in its unit and rounded to six figures, or is part of a
sentence of the JSON. Names of diagnoses have no digits, so that each number in an answer is one of
them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

MOST_TOKENS = 2000
"""What an answer may take of an assistant's memory, with its structured part."""
PIECES = re.compile(r"[A-Za-z]{1,4}|\d{1,3}|\S")
"""Four letters, three digits or one other character: the tokenizers in use take more of a word, at
most three digits, and most pairs of marks at once, so that they count fewer."""
MOST_SHOWN = 12
"""Columns and findings that are listed one by one."""
Json = Mapping[str, Any]


def tokens(text: str) -> int:
    """A bound on the tokens of a text without a tokenizer: its pieces, or a third of its bytes."""
    return max(len(PIECES.findall(text)), len(text.encode()) // 3 + 1)


@dataclass
class Text:
    """Lines of an answer, each with a rank: those of the highest rank are left out first."""

    lines: list[tuple[int, str]] = field(default_factory=list)

    def add(self, rank: int, *lines: str) -> None:
        """Add lines at the end."""
        self.lines += [(rank, line) for line in lines if line]

    def fitted(self, structured: Json, rest: str) -> str:
        """As many lines as there is room for beside the structured part.

        rest: where the others are; the last line if some are left out.
        """
        room = MOST_TOKENS - tokens(json.dumps(structured)) - tokens(rest)
        lines = [line for _, line in self.lines]
        wanted = sorted(range(len(lines)), key=lambda place: (self.lines[place][0], place))
        kept: set[int] = set()
        whole = True
        for place in wanted:
            needed = tokens(lines[place])
            if needed > room and not kept:
                lines[place], whole = _cut(lines[place], room), False
            elif needed > room:
                whole = False
                break
            kept.add(place)
            room -= needed
        shown = [line for place, line in enumerate(lines) if place in kept]
        return "\n".join([*shown, *([] if whole else [rest])])


def _cut(line: str, room: int) -> str:
    """As many words of a line as there is room for."""
    words: list[str] = []
    used = 1
    for word in line.split(" "):
        used += tokens(word)
        if used > room:
            return " ".join([*words, "…"])
        words.append(word)
    return line


def of_inspection(name: str, seen: Json) -> tuple[str, dict[str, Any]]:
    """What a table holds, and how it is diagnosed: text, and its structured part."""
    table, text = seen["json"], Text()
    text.add(0, f"{table['file']}: {table['kind'] or 'unknown machine'} ({seen['kind_why']}).")
    text.add(1, *(f"Look here: {warning}." for warning in table["warnings"]))
    text.add(1, *_to_diagnose(seen))
    shown = list(table["columns"].items())
    for column, guess in shown[:MOST_SHOWN]:
        text.add(2, f"Column {column}: {guess['name']}, {_unit(guess)} ({guess['why']}).")
    text.add(3, *(f"{fact}: {words}." for fact, words in table["facts"].items()))
    text.add(4, *(f"Column {column}: {why}." for column, why in table["unused"].items()))
    structured = {
        "inspection": name,
        "kind": table["kind"],
        "motion": table["motion"],
        "columns": _columns(seen),
        "robot_text": _robot_text(seen),
    }
    return text.fitted(structured, _rest("inspections", name)), structured


def _columns(seen: Json) -> list[str]:
    """The options of an inspection as `diagnose` takes them."""
    return [one for one in seen["json"]["options"] if one != "--set"]


def _unit(guess: Json) -> str:
    unit = guess["unit"] or "no unit said"
    return unit if guess["scale"] == 1.0 else f"{_figure(guess['scale'])} {unit}"


def _robot_text(seen: Json) -> str | None:
    """A robot file that is whole without a number that only its owner knows."""
    kind, motion = seen["json"]["kind"], seen["json"]["motion"]
    if kind == "range_sensor":
        return "{kind: range_sensor, name: sensor}"
    if kind != "servo_axis" or seen["needs_inertia"]:
        return None
    zero = ", zero: arbitrary" if seen["zero"] == "arbitrary" else ""
    return f"{{kind: servo_axis, name: axis, motion: {motion or 'rotary'}{zero}}}"


def _to_diagnose(seen: Json) -> Iterator[str]:
    kind, motion, columns = seen["json"]["kind"], seen["json"]["motion"], _columns(seen)
    if kind is None:
        yield "No machine that deltactl diagnoses is seen in it: ask what the columns are."
        return
    if columns:
        unit = ", with the unit of the axis for UNIT" if "unit=UNIT" in columns else ""
        yield f"To diagnose it, pass columns: {json.dumps(columns, ensure_ascii=False)}{unit}."
    if seen["own_run"]:
        yield "It is a run that deltactl recorded: pass the robot file that it was made with."
    elif robot := _robot_text(seen):
        doubt = "" if motion or kind != "servo_axis" else ", with linear in it if the axis slides"
        yield f"Without a robot file, pass robot_text: {robot}{doubt}."
    else:
        yield f"It needs a robot file of kind {kind}, which 'deltactl init' writes."


def of_diagnosis(name: str, made: Json) -> tuple[str, dict[str, Any]]:
    """Verdict, steps and findings: text, and its structured part."""
    answer, says, text = made["json"], made["says"], Text()
    names = ", ".join(answer["recordings"])
    text.add(0, f"Diagnosis {name} of {names} against {answer['robot']}: {answer['verdict']}.")
    text.add(0, *says["verdict"])
    text.add(1, *_headed("What to do:", says["steps"]))
    text.add(2, *_headed("Findings:", says["findings"]))
    text.add(3, *says["helps"])
    text.add(2, *says["or_else"])
    text.add(4, *says["remarks"])
    if answer["findings"]:
        text.add(1, f"More of a finding: explain, diagnosis {name}. What next: next_run.")
    found = [_found(number, one) for number, one in enumerate(answer["findings"], 1)]
    structured = {
        "diagnosis": name,
        "verdict": answer["verdict"],
        "probability_nothing_missing": _round(answer["probability_nothing_missing"]),
        "findings": found[:MOST_SHOWN],
        "json": resource("diagnoses", name),
    }
    return text.fitted(structured, _rest("diagnoses", name)), structured


def of_finding(name: str, made: Json, number: int) -> tuple[str, dict[str, Any]]:
    """One finding in full: text, and its structured part."""
    answer, says, text = made["json"], made["says"], Text()
    found = answer["findings"][number - 1]
    evidence = found["evidence"]
    text.add(0, says["findings"][number - 1])
    text.add(1, *(f"Size: {line}." for line in _sizes(found)))
    text.add(
        2, f"Evidence: delta_chi2 {_figure(evidence['delta_chi2'])}, p {_figure(evidence['p'])}."
    )
    text.add(2, f"Share of the model error: {_figure(found['share_of_mismatch'])}.")
    if found["probability"] is not None:
        text.add(2, f"Probability: {_figure(found['probability'])}.")
    for other in found["alternatives"]:
        share = "" if other["probability"] is None else _figure(other["probability"])
        how = f"probability {share}, " if share else ""
        worse = f"delta_chi2 {_figure(other['delta_chi2'])}"
        text.add(2, f"Or else: {other['effect']} at {other['component']} ({how}{worse}).")
    text.add(3, *_where(found["where"]))
    text.add(3, *_headed("What to do about the whole diagnosis:", says["steps"]))
    text.add(4, *says["or_else"], *says["helps"])
    structured = {"diagnosis": name, "verdict": answer["verdict"], "finding": _found(number, found)}
    return text.fitted(structured, _rest("diagnoses", name)), structured


def of_next_run(name: str, made: Json) -> tuple[str, dict[str, Any]]:
    """What would settle what is open: text, and its structured part."""
    answer, says, text = made["json"], made["says"], Text()
    plan = answer["next_experiment"]
    text.add(0, *says["verdict"])
    if plan is None:
        text.add(0, "No run of deltactl is proposed: none would tell more, or none can be made.")
    else:
        text.add(0, f"A run of {_figure(plan['minutes'])} min is proposed.")
    text.add(1, *says["or_else"], *_headed("Steps:", says["steps"]))
    if plan is not None:
        job = yaml.safe_dump(plan["job"], sort_keys=False, default_flow_style=None)
        text.add(
            2,
            "The job; save it as a file, look at it with 'deltactl check', and ask before"
            f" anything moves:\n{job}",
        )
    for one in answer["not_testable"]:
        text.add(3, f"Not seen here: {one['effect']} at {one['component']}, as {one['why']}.")
    for one in answer["smallest_detectable"]:
        size = f"{one['parameter']} {_figure(one['value'])}{_of_unit(one['unit'])}"
        text.add(4, f"Smallest that shows here: {one['effect']} at {one['component']}, {size}.")
    structured = {
        "diagnosis": name,
        "verdict": answer["verdict"],
        "minutes": None if plan is None else _round(plan["minutes"]),
        "tells_apart": [] if plan is None else plan["tells_apart"][:MOST_SHOWN],
    }
    return text.fitted(structured, _rest("diagnoses", name)), structured


def resource(kind: str, name: str) -> str:
    """Where the JSON of an answer is."""
    return f"deltactl://{kind}/{name}"


def _rest(kind: str, name: str) -> str:
    return f"There is more in the resource {resource(kind, name)}, the whole JSON."


def _headed(head: str, lines: Sequence[str]) -> list[str]:
    return [head, *lines] if lines else []


def _found(number: int, finding: Json) -> dict[str, Any]:
    """A finding by its numbers; the size is that of its first parameter."""
    size = next(iter(finding["parameters"].items()), None)
    made = {
        "number": number,
        "effect": finding["effect"],
        "component": finding["component"],
        "probability": _round(finding["probability"]),
    }
    if size is not None:
        name, result = size
        made |= {
            "parameter": name,
            "value": _round(result["value"]),
            "interval": _round(list(result["ci95"])),
            "unit": result["unit"],
        }
    return made


def _sizes(finding: Json) -> Iterator[str]:
    for name, result in finding["parameters"].items():
        several = isinstance(result["value"], list)
        values = result["value"] if several else [result["value"]]
        ends = result["ci95"] if several else [result["ci95"]]
        for value, pair in zip(values, ends, strict=False):
            low, high = pair if len(pair) == 2 else (None, None)
            unit = _of_unit(result["unit"])
            yield f"{name} {_figure(value)}{unit}, interval {_figure(low)} to {_figure(high)}"


def _of_unit(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def _where(where: Json) -> Iterator[str]:
    if where["axes"]:
        yield f"Shows in: {', '.join(where['axes'])}."
    if where["regime"]:
        yield f"When: {where['regime']}."
    times = [f"{_figure(low)} to {_figure(high)} s" for low, high in where["times_s"][:MOST_SHOWN]]
    if times:
        yield f"Times: {', '.join(times)}."


def _figure(value: float | None) -> str:
    return "without a bound" if value is None else f"{value:.6g}"


def _round(value: Any) -> Any:
    """Six figures, of each number in a list."""
    if isinstance(value, list):
        return [_round(one) for one in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value
