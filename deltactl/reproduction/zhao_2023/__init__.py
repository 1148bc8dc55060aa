"""Zhao et al. 2023: a stepper delta steered by a deep network, open loop."""
