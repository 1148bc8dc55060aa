"""The tab of recordings: a line for each, its diagnosis, and what follows from the answer."""
