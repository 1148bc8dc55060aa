"""How far values scatter, said without their outliers."""

MAD_TO_SIGMA = 1.4826
"""Standard deviation of normal noise over its median absolute deviation: 1 / Phi^-1(3/4) (Rousseeuw
and Croux 1993, J. Am. Stat. Assoc. 88, 1273-1283)."""
