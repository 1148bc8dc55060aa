"""The search for the best set of effects.

In: a detection. Out: a fitted set. `search` is its course, `state` what it knows, `criterion` says
which of two sets is better, the others are its moves: `addition`, `removal`, `exchange`.
"""
