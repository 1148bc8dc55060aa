"""All prose of a diagnosis.

In: the fields of an answer. Out: sentences and units for the terminal, the page and `says`.
"""
