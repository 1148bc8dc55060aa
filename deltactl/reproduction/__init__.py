"""Both papers over again: their experiments, tables and figures, beside what was printed."""
