"""Ground of a process on ROS: start, end, parameters, clocks, quality of service."""
