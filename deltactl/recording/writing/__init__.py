"""Onto the disk: from what happens during a run to an MCAP file, and which files are kept.

In: events from any thread of the controller. Out: a file that can be read up to where it was cut
off. A slow or full disk never delays a step. Old recordings make room for new ones.
"""
