"""Guard on a robot's own computer: what reaches the wheels."""
