"""Surveys: commanded counts with the positions measured there, for training and calibration."""
