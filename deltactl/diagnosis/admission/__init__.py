"""Does this recording belong to this machine?

In: recordings and a robot. Out: an `Admission` (`admit`): refusals, doubts, and the plants of what
was admitted.
"""
