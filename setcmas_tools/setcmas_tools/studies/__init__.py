"""Studies: many runs with varied parameters, and their table."""
