"""Does the machine survive?

In: faults, random input, days of running. Out: what was noticed, how soon, and what was not.
"""
