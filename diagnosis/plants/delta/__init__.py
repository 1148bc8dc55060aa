"""A delta robot as a `Model`.

In: its robot file and recordings. Out: predictions, candidates, and which tests make sense on it.
"""
