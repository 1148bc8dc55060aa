"""Commands that move or watch a robot, on hardware or simulated.

In: jobs, positions, a daemon's socket. Out: motion, live figures, recordings and their reports.
"""
