"""The numbers of the search: what a set must earn, by how much it must beat another, how many are
looked at.

What belongs to one effect is with the effect (`EffectKind`). Every other room whose numbers
decide has such a table (`options.py` in `observations`, `admission`, `plants`, `plants.delta`,
`plants.lone`, `estimation`, `evidence`, `score_tests`, `selection`, `assessment`, `experiment`,
`pipelines` and `answer`). How long the search may go on is in `estimation.options`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SearchOptions:
    """Limits of the search. Those of the first part decide what wins, the others how long it takes.

    Chi-squares throughout; shares are of a gain in chi-square.
    """

    better: float = 1.0
    """What something else must gain to take a place: no swaps back and forth over rounding."""
    choice: float = 12.0
    """What choosing one of a hundred candidates costs: -2 log of the odds, a little rounded up."""
    promoted: float = 12.0
    """What lifting the prior of a build tolerance must gain to make it a finding: as a choice."""
    tied: float = 11.0
    """Within which two explanations count as tied: one in a thousand by chance."""
    preferred: float = 10.0
    """How many times more probable an alternative must be to take the place of a finding: strong
    evidence (Jeffreys 1961, Theory of Probability, appendix B). Below that the one that fits better
    stays: at three times, priors known to a factor of three would decide."""
    spare: float = 0.1
    """What any effect may still do beside a shape that explains it all, of what that does more."""
    calmer: float = 0.99
    """Noise that shrinks by more than this once an explanation is found had model error in it."""
    most_terms: int = 5
    """Effects in one set: more were never distinguished in one recording."""
    pile: int = 3
    """So many effects may be a pile that represents one cause in no list."""
    most_shapes: int = 2
    """Spline terms in one set."""

    around_contact_s: float = 0.3
    """Around a contact: touching down a little earlier, and what rings after it."""
    least_contact_m: float = 1e-6
    """A reading that a contact moves by less is away from it."""
    least_clear: float = 0.2
    """Share of the readings that must lie away from a contact for two sets to be judged by them
    alone: near it a stop's own shape decides."""

    # What is tried: more takes longer, and was not seen to find more.
    tried: int = 6
    """Candidates fitted for one more effect,"""
    tried_by_p: int = 3
    """and, where those miss it, of what build tolerances are least able to explain: an arm that is
    a little off makes six lengths and homes promise more than friction of that arm does."""
    tried_share: float = 0.4
    """Share of the best candidate's linearised gain with which another is fitted."""
    tried_of_alternatives: int = 2
    """The same where another explanation is known, beside what that has."""
    tried_instead: int = 2
    """Candidates fitted in the place of a term."""
    instead_share: float = 0.8
    """Share of what is lost without a term that another must promise to be fitted in its place."""
    tried_pairs: int = 3
    """Pairs fitted in the place of the newest two."""
    least_more: float = 5.0
    """What two others must promise beyond the newest two for a refit."""
    group_share: float = 0.3
    """Share of what a set explains that a group alone must promise."""
    groups: int = 2
    """Groups that a set is grown from."""
    ties_refitted: int = 6
    """Alternatives fitted in the place of each finding."""
    tie_share: float = 0.75
    tie_reach: float = 60.0
    """An alternative that promises less than this share, or so much less, is not fitted."""
    alternative_shapes: int = 2
    """Spline terms fitted beside or instead of a set."""
    optimism: float = 1.5
    """How much more than its linearised gain an effect may bring."""
    clearly: float = 10.0
    """So many times what a term must gain, and no fit of the others to its end will change it, nor
    that another is dropped: what cannot be done without is needed all the more beside fewer."""

    # Fits that are begun and given up.
    quick: int = 2
    """Steps of a first try."""
    hopeful: float = 0.7
    hope: float = 40.0
    """Share of the best first try's gain, and chi-square behind it, with which a fit is brought to
    its end."""
    reach: float = 300.0
    reach_share: float = 0.05
    """Chi-square, and share of what a term explains, that another may catch up after a try."""

    # Ends of loops that hardly ever come to them.
    most_turns: int = 8
    """Turns of adding, exchanging and leaving out."""
    most_swaps_of_ties: int = 2
    """How often a finding is exchanged for an alternative that is far more probable."""
    most_noise_rounds: int = 3
    """How often the noise is estimated anew beside what was found."""
    most_final_fits: int = 6
    """Fits of the chosen set, each from where the last one ended."""


@dataclass(frozen=True, slots=True)
class PenaltyOptions:
    """What an explanation must earn, in chi-square, and what passes for a tolerance."""

    coordinate: float = 4.0
    """Each coordinate of a candidate, beyond the others: two standard deviations."""
    event: float = 14.0
    """A thing that happens once: about what one of a thousand moments costs (2 log 1000 = 13.8)."""
    group: float = 10.0
    """That three arms err alike is less likely than one other cause that looks the same."""
    in_name_only: float = 50.0
    """An effect that does not do what it is called after bends like any shape, and costs like one.
    """
    whole_travel: float = 0.97
    """Share of the travel from which on a period is one bend."""
    spline: float = 26.0
    """A spline term, which is no cause that anybody could name: more than any named effect."""
    spline_factor: float = 4.0
    """So many times more than a named effect where another explanation may have left its shape: a
    spline term fits many things a little."""
    within: float = 2.0
    """Usual spreads within which an error is no fault by itself."""
    care: tuple[float, ...] = (1.0 / 60.0, 0.2, 1.0)
    """Shares of the usual tolerances that building may leave, of which the evidence decides,"""
    careless: float = -2.0
    """and the log odds of each but the first: most machines are built as their file says."""
    most_careful: float = 1.0 / 60.0
    """Share of the usual tolerances that the most careful building leaves: 0.025 mm at a sensor,
    0.01 mm in an arm, 0.03 mrad at a home."""


@dataclass(frozen=True, slots=True)
class SizePriorOptions:
    """The prior of sizes around what is typical of an effect, and how it is integrated."""

    width: float = math.log(3.0)
    """Standard deviation of the log of a size: a factor of three either way."""
    known_to: float = 3.0
    """The factor to which that spread itself is known: answers say what changes within it."""
    reach_sigma: float = 4.0
    """Standard deviations of the log of a size out to which is integrated,"""
    points: int = 41
    """and points of that quadrature."""
    directions: int = 48
    """Directions of a size with several components, over which is averaged."""
    shows: float = 3.0
    """Standard deviations of the readings' noise below which a size does not show."""


OPTIONS = SearchOptions()
PENALTIES = PenaltyOptions()
SIZE_PRIORS = SizePriorOptions()
"""As the engine is used."""
