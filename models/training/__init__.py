"""Trains networks and writes them as TFLite files; an extra (`.[training]`), not for the Pi."""
