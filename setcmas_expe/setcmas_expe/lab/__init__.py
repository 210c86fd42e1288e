"""A lab: its robots, motion capture, arena and limits, and the checks of the doctor."""
