"""The model of a robot: its file, linkage, chain of effects, and networks."""
