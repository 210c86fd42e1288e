"""The ROS nodes of the tools."""
