"""What the distance sensors show of the arms: are they seen, at home, where the counts say?

In: readings, counts and the robot file. Out: blindness, lost steps, how sure a home is.
"""
