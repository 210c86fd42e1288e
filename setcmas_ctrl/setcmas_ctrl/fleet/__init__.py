"""The fleet as a controller process hears it: its robots, their poses, its pause."""
