"""Do the tests notice mistakes?

In: small mistakes (known, or made by rule: `operators`) and the tests of each folder (`table`).
Out: the mistakes that no test noticed (`mutants` prints them).
"""
