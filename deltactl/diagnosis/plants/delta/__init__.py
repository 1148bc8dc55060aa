"""A delta robot as a `Model`.

In: its robot file and recordings. Out: predictions, candidates, which tests make sense on it, and
the runs that it may safely do next (`next_runs`).
"""
