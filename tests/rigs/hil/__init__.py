"""Hardware in the loop without the hardware: a modelled Pi below the real libraries."""
