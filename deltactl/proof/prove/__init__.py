"""`deltactl demo prove`: draw cases, diagnose them blind, and say how often the answer is right."""
