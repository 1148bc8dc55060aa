"""The proof's own ranging sensors. In: true distances. Out: readings with noise and faults."""
