"""Is the diagnosis right?

In: recordings, real or simulated, with what is known of them. Out: tables of what was found, how
often, and how far off.
"""
