"""deltactl and other tools on the same drawn machines."""
