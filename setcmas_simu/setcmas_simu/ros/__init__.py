"""What every process on ROS shares: start and end, quality of service, velocity commands."""
