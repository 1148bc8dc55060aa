"""The whole way of a recording, the same stages for every kind of plant.

In: a plant with its readings. Out: a `Diagnosis`. What differs is how an explanation is searched
and fitted: `nonlinear` for machines whose effects are fitted together (`plants/contract.py`),
`regression` for those whose model error is a sum of columns (`plants/regression.py`). Both settle
on one, which `way` turns into the answer; `by_machine` chooses, and joins the two answers of a
servo robot.
"""
