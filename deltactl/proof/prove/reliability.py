"""How sure a share is; and whether of what is claimed with 0.9 nine in ten are true.

Every probability of an answer is a claim: of a finding (unknown: that something outside the
vocabulary acts), of each alternative, and that nothing is missing. Claims in ten bins of equal
width; the calibration error is the mean distance between stated and true shares, weighted by
claims (Naeini, Cooper and Hauskrecht 2015, AAAI, "expected calibration error").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

import numpy as np

from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding

Z95 = 1.959963984540054


def wilson(hits: int, cases: int, z: float = Z95) -> tuple[float, float]:
    """95 % limits of a share (Wilson 1927, J. Am. Stat. Assoc. 22, 209); (0, 1) for no cases."""
    if cases == 0:
        return 0.0, 1.0
    share, room = hits / cases, z**2 / cases
    middle = (share + 0.5 * room) / (1.0 + room)
    half = z * np.sqrt(share * (1.0 - share) / cases + 0.25 * room / cases) / (1.0 + room)
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def median_limits(values: Sequence[float], draws: int = 2000) -> tuple[float, float]:
    """95 % limits of a median by the bootstrap, always with the same draws."""
    if not values:
        return float("nan"), float("nan")
    rng = np.random.default_rng(0)
    array = np.asarray(values, dtype=float)
    medians = np.median(array[rng.integers(0, len(array), (draws, len(array)))], axis=1)
    low, high = np.quantile(medians, [0.025, 0.975])
    return float(low), float(high)


Claim = tuple[float, bool]
"""A probability that was stated, and whether it was so."""
BINS = 10
SURE = 0.95
SIDE, MARGIN = 320, 50


@dataclass(frozen=True)
class Bin:
    """Claims of about one probability."""

    low: float
    high: float
    stated: float
    true: float
    limits: tuple[float, float]
    """95 % limits of the true share (Wilson)."""
    claims: int


def claims_of(answer: Diagnosis, truth: Sequence[tuple[str, str]]) -> list[Claim]:
    """What an answer claims, against the hidden effects and components."""
    names, found = set(truth), list[Claim]()
    unknown = any(effect == "unknown" for effect, _ in truth)
    if answer.probability_nothing_missing is not None:
        found.append((answer.probability_nothing_missing, not truth))
    for finding in answer.findings:
        if finding.probability is None:
            continue
        own = unknown if finding.effect == "unknown" else _name(finding) in names
        found.append((finding.probability, own))
        together: set[str] = set()
        for other in finding.alternatives:
            if other.probability is None or (other.together and other.effect in together):
                continue
            together |= {other.effect} if other.together else set()
            true = unknown if other.effect == "unknown" else _name(other) in names
            found.append((other.probability, true))
    return found


def _name(claimed: Finding | Alternative) -> tuple[str, str]:
    return claimed.effect, claimed.component


def bins(claims: Sequence[Claim]) -> list[Bin]:
    """Claims by what they state; bins without any are left out."""
    found = []
    for number in range(BINS):
        own = [c for c in claims if min(int(c[0] * BINS), BINS - 1) == number]
        if not own:
            continue
        count, hits = len(own), sum(true for _, true in own)
        ends, stated = (number / BINS, (number + 1) / BINS), sum(p for p, _ in own) / count
        found.append(Bin(*ends, stated, hits / count, wilson(hits, count), count))
    return found


def calibration_error(claims: Sequence[Claim]) -> float:
    """Expected calibration error; nan without claims."""
    if not claims:
        return float("nan")
    return sum(part.claims * abs(part.stated - part.true) for part in bins(claims)) / len(claims)


def sure_claims(claims: Sequence[Claim]) -> list[bool]:
    """Whether each claim of at least 0.95 is true."""
    return [true for p, true in claims if p >= SURE]


def diagram(claims: Sequence[Claim], title: str) -> str:
    """The reliability diagram as an SVG drawing: stated across, true upwards, limits as bars."""
    size = SIDE + 2 * MARGIN

    def at(x: float, y: float) -> tuple[float, float]:
        return MARGIN + SIDE * x, MARGIN + SIDE * (1.0 - y)

    (left, bottom), (right, top) = at(0.0, 0.0), at(1.0, 1.0)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size + 20}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{size}" height="{size + 20}" fill="#ffffff"/>',
        f'<text x="10" y="20" font-size="13">{escape(title)}</text>',
        f'<rect x="{left}" y="{top}" width="{SIDE}" height="{SIDE}" fill="none" stroke="#888"/>',
        f'<path d="M{left} {bottom}L{right} {top}" stroke="#888" stroke-dasharray="4 4"/>',
        f'<text x="{left}" y="{bottom + 34}">stated probability, 0 to 1; beside each point its '
        "claims</text>",
        f'<text transform="translate({left - 14},{bottom}) rotate(-90)">share that was true</text>',
    ]
    for part in bins(claims):
        x, y = at(part.stated, part.true)
        low, high = at(0.0, part.limits[0])[1], at(0.0, part.limits[1])[1]
        parts += [
            f'<path d="M{x:.1f} {low:.1f}L{x:.1f} {high:.1f}" stroke="#2a6f97"/>',
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="#2a6f97">'
            f"<title>{part.stated:.3f} stated, {part.true:.3f} true</title></circle>",
            f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" fill="#555555">{part.claims}</text>',
        ]
    return "\n".join([*parts, "</svg>"]) + "\n"
