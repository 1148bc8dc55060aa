"""A chain of joints that a URDF or MJCF describes, by the efforts of all its joints at once.

See deltactl/README.md.
"""
