"""The whole way of a recording, the same stages for every kind of plant.

In: a plant with its readings. Out: a `Diagnosis`. `regression` selects an explanation and settles
on it, which is the answer; `by_machine` chooses the plant's extras, and joins the two answers of a
servo robot.
"""
