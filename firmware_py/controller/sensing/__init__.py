"""What the ranging sensors say of the arms: are they seen, at home, where the counts put them?

In: readings, counts and the robot file. Out: blindness, lost steps, how sure a home is.
"""
