"""Single axes, lone sensors and servo joints, with a search and an answer of their own."""
