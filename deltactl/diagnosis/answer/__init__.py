"""The answer: its records, and the verdict.

In: findings, figures of the fit, the test of what is left. Out: a `Diagnosis`, the contract's JSON.
Every kind of machine is answered by `assembly.assembled`. Knows no room of the engine.
"""
