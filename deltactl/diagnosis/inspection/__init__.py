"""What a table of somebody's seems to be: its columns, units, rate, joints and kind of machine.

In: a table or a log. Out: an `Inspection`, with the mapping that reads it.
"""
