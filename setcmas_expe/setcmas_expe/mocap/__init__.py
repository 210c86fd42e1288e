"""Motion capture: sources, samples and tracks of poses."""
