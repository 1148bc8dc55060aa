"""The robot for Foxglove: recordings and a live server with Foxglove's own message schemas.

In come a recorded run, or the daemon's status; out go frame transforms, a scene of the robot, poses
of target, commanded and measured, ranges and log, which Foxglove's 3D panel shows without set-up.
Needs the extra `foxglove`.
"""
