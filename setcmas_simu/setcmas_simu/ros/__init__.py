"""Ground of every process on ROS: start and end, parameters, clocks, quality of service."""
