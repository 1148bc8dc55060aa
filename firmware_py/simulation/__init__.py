"""The simulated robot behind the fakes: step edges in, distances out."""
