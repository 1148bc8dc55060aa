"""From a hidden effect to better tracking: record, diagnose, correct, run again, compare.

In: recordings and a robot file (for the demonstration a robot of another make with something built
in). Out: the corrected robot file, the network that belongs to it, what is compensated and what is
left as work to do, and how much better the robot draws.
"""
