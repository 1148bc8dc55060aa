"""One file per kind of machine on one contract: predictions, candidates, nuisances.

In: readings and a robot file. Out: a `Model` for the engine, which names no machine itself.
"""
