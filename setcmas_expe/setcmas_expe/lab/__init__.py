"""Description of a lab (robots, motion capture, arena, limits), and what is found in it."""
