"""Single axes, lone sensors and servo joints: their own search and answer, until they stand on the one pipeline."""
