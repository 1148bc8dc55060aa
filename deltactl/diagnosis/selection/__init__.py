"""Which explanation to accept, and what else would explain the recording as well.

In: a search. Out: one explanation with its ambiguity set: named effects, build tolerances or
unknown physics; for regressors the posterior over sets.
"""
