"""What the cmd_vel bridges of a fleet share, and their process."""
