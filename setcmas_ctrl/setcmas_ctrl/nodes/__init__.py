"""The ROS 2 nodes that run control laws."""
