"""Velocity commands: their senders and listeners in the ROS graph, and their publisher."""
