"""Finds the robot's real lengths, homes and sensor errors in a data set; needs scipy (an extra)."""
