"""Velocity commands: who sends and hears them in the ROS graph, and their publisher."""
