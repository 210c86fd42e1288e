"""Ground of every process on ROS: start and end, quality of service, velocity commands."""
