"""What decides: states, homing, the queue, and what happens when something goes wrong.

In: requests of a user, readings of the sensors, and what the step output says. Out: ticks for the
output, and the status. `jobs` carries out what was queued; `sensing` judges what the sensors see.
"""
