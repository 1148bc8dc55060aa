"""The whole way of a recording, one function a kind of plant: each reads like the method.

In: a plant with its readings. Out: a `Diagnosis`. `nonlinear` is for machines whose effects are
fitted together (`plants/contract.py`), `regression` for those whose mismatch is a sum of known
columns (`plants/regression.py`), `servo_robot` for a robot that is both.
"""
