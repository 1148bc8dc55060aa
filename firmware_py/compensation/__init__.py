"""What is done about a robot's known effects while it moves.

In: a plan made by the inverse kinematics, and the effects that a robot file believes in. Out: the
same plan with play taken up where arms turn round, growth followed as the arms warm up, and late
drives told early; and in words what is compensated, what is not and why.
"""
