"""Feedback from the ranging sensors: errors that came while a job runs are estimated and corrected.

In: edges really sent, good readings, and what a job allows. Out: a few extra steps between those of
the plan, never more than the job allows, and none while a sensor rather than an arm may be wrong.
"""
