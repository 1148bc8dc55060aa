"""Flat recordings, one row a sample: the exchange format of the diagnosis.

In: a recorded run, or a file (CSV, Parquet, MATLAB, MCAP; logs and tables of others under any
names). Out: a `FlatRecording` of columns with units, or the same written to a file.
"""
