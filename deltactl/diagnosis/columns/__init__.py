"""Tables of others become columns of the contract: names in many languages, units, a mapping.

In: a table or a log, and what is said of its columns. Out: a flat recording.
"""
