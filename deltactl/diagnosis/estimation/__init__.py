"""Sizes from readings: noise, least squares, splines, moments, and the work that they may take.

In: a plant and a set of terms. Out: a noise model, and a `Solution` in least squares.
"""
