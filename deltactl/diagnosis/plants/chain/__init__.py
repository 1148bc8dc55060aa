"""A chain of joints that a URDF or MJCF describes, by its efforts or by measured poses."""
