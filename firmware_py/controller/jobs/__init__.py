"""Jobs: those that wait, the one that runs, how they ended, and what they leave behind.

In: a job that is checked and planned, and the time. Out: ticks for the step output, events for
the recorder, and a result.
"""
