"""Tables and logs of other programs: what their columns seem to be, and reading them by a mapping.

In: a table or a log, and what its owner says of the columns. Out: an `Inspection`, which proposes a
mapping, and a flat recording with the columns, names and units of the contract.
"""
