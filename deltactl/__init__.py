"""Runs rotary delta robots, and finds out where a robot and its model differ.

`config`, `drivers`, `models`, `firmware_py` and `systemd` stand at the top of a working copy; here
they are links, so that everything is imported as `deltactl.*`. An installed package holds them as
folders.
"""
