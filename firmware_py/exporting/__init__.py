"""Robots and recordings for other programs: URDF, MJCF, and MCAP with ROS 2 messages."""
