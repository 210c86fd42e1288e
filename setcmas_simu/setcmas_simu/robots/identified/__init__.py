"""Robots identified from an experiment: gain, lag and delay, and their model file."""
