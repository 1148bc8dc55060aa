"""Many recordings of many robots at once.

In come recordings and a folder of robot files; out go a table of all answers (Parquet) and one
page: which robots have what, how it grows, what comes in groups, where to look first. One
diagnosis a recording, spread by Dask. Needs the extra `fleet`.
"""
