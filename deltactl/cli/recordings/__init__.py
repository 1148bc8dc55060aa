"""Commands that need recordings and no robot: diagnose, correct, prove, describe, show.

In: recordings and robot files. Out: what the model leaves out, and a robot file that has it.
"""
