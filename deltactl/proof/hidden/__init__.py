"""What can be wrong with a robot of the proof: the vocabulary, and oddities beyond it."""
