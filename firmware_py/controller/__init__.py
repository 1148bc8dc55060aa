"""What decides: states, homing, the queue, and what happens when something goes wrong."""
