"""Commands about networks: collect data, train, evaluate, reproduce what papers did.

In: jobs, data sets, settings. Out: data sets, networks, tables of errors.
"""
