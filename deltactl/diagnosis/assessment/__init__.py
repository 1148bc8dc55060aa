"""What a chosen explanation is good for.

In: a fitted set. Out: sizes with intervals, model error on unseen data, detection limits,
significance.
"""
