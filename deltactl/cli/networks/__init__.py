"""Commands for networks: collect data, train, evaluate, reproduce papers.

In: jobs, data sets, settings. Out: data sets, networks, tables of errors.
"""
