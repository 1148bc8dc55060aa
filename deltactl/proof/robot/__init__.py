"""The proof's robot in MuJoCo: bodies, closed loops, gears, and how it is run.

In: dimensions and masses as built, with the hidden effects, and step counts over time.
Out: the true position of the platform and the angles of the arms at the asked times.
"""
