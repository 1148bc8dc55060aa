"""How the proof's robot is moved: from curves in space, by its own inverse, to step counts.

In: what a job draws, and the nominal linkage. Out: counts of three motors over time.
"""
