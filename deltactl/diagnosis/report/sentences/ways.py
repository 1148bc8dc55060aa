"""How what an answer proposes is done: by commands in a terminal, by buttons on a page."""

from __future__ import annotations

from dataclasses import dataclass

OR_EFFORT = ", or record the effort as well"


@dataclass(frozen=True, slots=True)
class Ways:
    """The words for each thing to do; {all} stands for the option of findings that are not sure."""

    describe: str
    """A finding in the robot file, instead of a repair; added to what to do."""
    keep: str
    """The same, of a lone machine, which no job of ours moves: a sentence of its own. Both are
    empty where the corrected robot file is written anyway."""
    unsure_too: bool
    """Whether the two above can also be done with findings that are not sure."""
    run_first: str
    """The proposed run, before anything is taken apart."""
    run: str
    """The proposed run, as what would check a finding."""
    on_top: str
    """Of an effect that the robot file has already."""
    left_out: str
    """Before a finding that the corrected robot file does not hold."""
    all_compared: str
    """What compares the rest where the search ended early."""
    or_effort: str
    """How the effort tells causes apart, after another way; empty where nothing reads one."""
    table: str
    """Where the numbers of a table are; {unit} is what they are in."""


TERMINAL = Ways(
    describe=" (deltactl diagnose ... --save-robot NEW.yaml{all} does)",
    keep=(
        "What you leave as it is can be entered in the robot file, so that the next diagnosis looks"
        " for more: run 'deltactl diagnose' once more with --save-robot NEW.yaml{all}."
    ),
    unsure_too=True,
    run_first=(
        "Before anything is taken apart, record the run proposed below, which is made to tell the"
        " causes apart (--next-job JOB.yaml writes it), and diagnose it together with this"
        " recording."
    ),
    run="run the job proposed above (--next-job JOB.yaml) and diagnose both recordings",
    on_top="It comes on top of what the robot file has of it already; --save-robot adds both.",
    left_out="left out (--all writes it too): ",
    all_compared="--thorough compares the rest, which takes longer",
    or_effort=OR_EFFORT,
    table="--json FILE writes them as `table`, in {unit}",
)
PAGE = Ways(
    describe=" (the corrected robot file does: the buttons below)",
    keep=(
        "What you leave as it is can be entered in the robot file, so that the next diagnosis looks"
        " for more: save the corrected robot file (the button below)."
    ),
    unsure_too=False,
    run_first=(
        "Before anything is taken apart, run the experiment that would tell more (the button"
        " below), and diagnose its recording together with this one."
    ),
    run="run the experiment that would tell more (the button below) and diagnose both recordings",
    on_top="It comes on top of what the robot file has of it already; the corrected file has both.",
    left_out="left out, as it is not certain: ",
    all_compared="in a terminal, 'deltactl diagnose --thorough' compares the rest",
    or_effort=OR_EFFORT,
    table="in a terminal, 'deltactl diagnose --json FILE' writes them as `table`, in {unit}",
)
