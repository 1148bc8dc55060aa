"""Tables of others become columns of the contract: their names, units and kind of machine.

In: a table or a log. Out: a flat recording, or an `Inspection` that says how to read one.
"""
