"""The answer: its records, the verdict, and what no answer may say of itself.

In: findings, figures of the fit, the test of what is left. Out: a `Diagnosis`, the contract's JSON.
Every kind of machine is answered by `assembly.assembled`; `consistency.contradictions` holds any
answer to the contract. Knows no room of the engine.
"""
