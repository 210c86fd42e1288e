"""The emulated lab: robots, motion capture and faults."""
