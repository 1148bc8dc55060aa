"""Fault campaign: what goes wrong is made to go wrong in the middle of a run, and judged."""
