"""Basis of a ROS process: start, end, parameters, clocks, quality of service."""
