"""Kinds of machine on one contract, `regression.RegressionPlant`; the engine names no machine.

In: readings and a robot file. Out: a plant whose model error is a sum of known columns, everywhere
(`lone`, `chain`) or near a set of effects at sizes (`delta`).
"""
