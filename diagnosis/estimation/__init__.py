"""Numbers from readings: noise, least squares, sizes with their uncertainty.

In: a plant and a set of terms. Out: estimates.
"""
