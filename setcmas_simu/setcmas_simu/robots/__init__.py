"""Robot models: how commands move a robot."""
