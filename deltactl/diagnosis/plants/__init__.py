"""Kinds of machine on two contracts, so that the engine names no machine itself.

In: readings and a robot file. Out: a `Model` (`contract`; effects are fitted together: `delta`) or
a `RegressionPlant` (`regression`; the model error is a sum of known columns: `lone`).
"""
