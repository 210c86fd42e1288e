"""Robot models: how robots follow commands."""
