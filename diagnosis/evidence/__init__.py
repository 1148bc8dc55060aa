"""What speaks for each candidate: the library of regressors, score tests, change points, detection.

In: estimates. Out: gains in chi-square with their p.
"""
