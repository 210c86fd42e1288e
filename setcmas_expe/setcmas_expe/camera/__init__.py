"""Camera over the floor that finds robots by printed tags."""
