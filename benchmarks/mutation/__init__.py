"""Do the tests notice mistakes?

In: small mistakes (`mistakes`: known, or made by rule) and the tests of each folder.
Out: the mistakes that no test noticed (`mutants` prints them).
"""
