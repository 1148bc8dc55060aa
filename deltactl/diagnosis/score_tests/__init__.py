"""What each candidate by itself would explain of the readings.

In: a fitted model and its candidates. Out: gains in chi-square with their p: of effects, pairs,
splines, sinusoids, change points and hysteresis.
"""
