"""What stands around robots: the border of an arena, obstacles."""
