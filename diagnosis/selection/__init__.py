"""Which set of effects explains the recording, what else would, and what could not be seen.

In: scores. Out: one explanation with its ambiguity set.
"""
