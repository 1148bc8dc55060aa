"""Paths: sequences of targets in space or in arm angles. One small file a shape."""
