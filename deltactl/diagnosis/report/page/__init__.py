"""The report of a diagnosis as one HTML file.

In: an answer and the picture of its mismatch. Out: HTML that needs no network.
"""
