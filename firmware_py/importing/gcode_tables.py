"""Which words of G-code do what here: what is taken, what changes nothing, what is refused."""

from __future__ import annotations

MM_M, INCH_M = 1e-3, 0.0254
UNITS = {20.0: INCH_M, 21.0: MM_M}
MOVES = (0.0, 1.0, 2.0, 3.0)
ARCS = (2.0, 3.0)
AXES = "XYZ"
CENTRE = "IJ"

GROUPS: dict[str, tuple[float, ...]] = {
    "moves": (*MOVES, 80.0),
    "planes": (17.0, 18.0, 19.0),
    "ways to give coordinates": (90.0, 91.0),
    "ways to give centres": (90.1, 91.1),
    "units": (20.0, 21.0),
}
"""Of these a line may have one each (NIST IR 6556, table 4)."""

SILENT = frozenset({17.0, 40.0, 49.0, 54.0, 64.0, 80.0, 90.1, 91.1, 94.0})
"""Settings that ask for what holds here anyway: plane XY, no tool, mm a minute, or are read."""

WITHOUT_MEANING = frozenset({15.0, 43.0, 50.0, 61.0, 61.1, 69.0, 92.1, 92.2, 98.0, 99.0})
"""Tool lengths, ends of what never began, exact stops: no part of a delta's path; noted."""

REFUSED: dict[float, str] = {
    18.0: "arcs in XZ cannot be made; arcs lie in XY (G17)",
    19.0: "arcs in YZ cannot be made; arcs lie in XY (G17)",
    28.0: "goes to a place that the machine knows; give the place with G0",
    30.0: "goes to a place that the machine knows; give the place with G0",
    41.0: "the tool's radius is not taken off; let the program that made the file do it",
    42.0: "the tool's radius is not taken off; let the program that made the file do it",
    53.0: "is a place in the machine's own frame; give it in the file's, which --origin places",
    92.0: "moves the origin; give it once, by --origin",
    93.0: "F as a time is not taken; let F be a speed (G94)",
    95.0: "F for a turn of the spindle is not taken; let F be a speed (G94)",
} | {
    float(code): "other origins are not known here; use one (G54), which --origin places"
    for code in range(55, 60)
}
"""What would change the path, and what to do instead."""

OTHER = "is not taken; G0 to G4, G17, G20, G21, G90, G91, G90.1, G91.1 are"

ENDS = (2.0, 30.0)
"""M words after which nothing is carried out."""
CALLS = (97.0, 98.0)
"""M words that call another part of a program."""
