"""The answer: its records, the verdict, and the contradictions that it must not contain.

In: findings, figures of the fit, the test of what is left. Out: a `Diagnosis`, the contract's JSON.
Every kind of machine is answered by `assembly.assembled`; `consistency.contradictions` holds any
answer to the contract. Knows no room of the engine.
"""
