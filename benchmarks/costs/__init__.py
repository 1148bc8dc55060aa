"""What things take.

In: one piece of the program at work. Out: its time, memory and punctuality on this machine.
"""
