"""Is anything missing, and how much speaks for one set of effects?

In: readings and a library of candidates. Out: a noise model from a saturated fit, the p of
"nothing is missing", and the log evidence of sets of regressors.
"""
