"""Machines by themselves as `RegressionPlant`s: axes, range sensors, the joints of a servo delta.

In: a robot file and recordings. Out: the model error, and a column for everything that may explain
it.
"""
