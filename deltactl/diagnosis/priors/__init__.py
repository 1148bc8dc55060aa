"""Priors: what is assumed before a recording is seen.

In: an effect. Out: what it must gain to be named (`penalties`), what it may leave behind
(`penalties` too), what every machine may be off by (`tolerances`), and the
numbers of the search and its penalties (`options`). Spreads and odds are at each `EffectKind`
(`models/effects`).
"""
