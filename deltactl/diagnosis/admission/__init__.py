"""Does this recording belong to this machine?

In: readings and a plant. Out: nothing, or a RecordingError of one line.
"""
