"""What a recorded run holds: the table of channels, and their messages.

In: what happened (a reading, a target, a block of step edges, the files and settings of the run).
Out: flat dictionaries that become JSON messages, their schemas, and the copies for viewers.
"""
