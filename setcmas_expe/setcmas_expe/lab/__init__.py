"""Description of a lab: robots, motion capture, arena, limits."""
