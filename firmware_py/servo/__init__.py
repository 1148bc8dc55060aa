"""Servo robots: the control law of Uzunovic 2013, the loop that runs it, and what guards it."""
