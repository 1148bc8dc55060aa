"""The micro delta of Uzunovic 2013 in MuJoCo: motors, gears, friction, gravity, encoders.

Shares no code with `models/` and `firmware_py/`; imports MuJoCo and numpy alone.
"""
