"""Uzunovic et al. 2013: kinematics, network, and acceleration control of the micro delta."""
