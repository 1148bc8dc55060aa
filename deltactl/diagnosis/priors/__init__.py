"""Priors: what is assumed before a recording is seen.

In: an effect. Out: how large it usually is and what it costs (`size_priors`), and what passes for a
tolerance (`options`). Spreads and odds are at each `EffectKind` (`models/effects`).
"""
