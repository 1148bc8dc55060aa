"""Where belief and recording differ: detect, locate, name, decide, report."""
