"""Distance sensors: the contract, the VL53L1X driver, gating, and the bank of three."""
