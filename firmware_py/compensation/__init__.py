"""Feed-forward for those of a robot's known effects that remember, or that change with time.

In: arm angles that an inverse kinematics chose, with their times, and the effects that a robot file
lists. Out: the angles to command instead (backlash taken up where arms turn round, growth
followed), and the steps of late drives, made early. What does not remember is the inverse's.
"""
