"""Paths of other programs become jobs: G-code, and tables of points.

In: a file of somebody else. Out: legs of a `way`, so that a job always holds its whole path.
"""
