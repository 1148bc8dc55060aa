"""Step outputs: the contract, two backends, and the pulse player they share."""
