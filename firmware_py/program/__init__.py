"""Jobs that are more than one path: in, a job file and what it includes; out, a checked program.

A program is moves with their plans, outputs to switch, waits, and blocks that are repeated.
"""
