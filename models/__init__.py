"""What we believe about a robot: its file, linkage, chain of effects, and networks."""
