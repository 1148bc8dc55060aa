"""Back from the disk: from an MCAP file, whole or cut off, to arrays.

In: a path. Out: a `Run` (times in ns of run time, counts in microsteps, lengths in metres), or a
RecordingError that says what is wrong with the file.
"""
