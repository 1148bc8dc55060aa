"""Feedback from the distance sensors: errors that arise in a job are estimated and corrected.

In: edges really sent, good readings, and what a job allows. Out: a few extra steps between those of
the plan, never more than the job allows, and none while a sensor rather than an arm may be wrong.
"""
