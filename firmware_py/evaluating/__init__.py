"""How wrong a network is on samples it was not trained on."""
