"""A robot file from a few answers, and a first job for it.

In: what somebody knows of a machine. Out: YAML texts that pass the checks they will be held to.
"""
