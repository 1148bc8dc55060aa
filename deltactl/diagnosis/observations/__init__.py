"""Recordings become data: columns and units, one clock, readings with their validity.

In: flat recordings. Out: `Readings`.
"""
