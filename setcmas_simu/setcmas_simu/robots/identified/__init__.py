"""Robots as an experiment shows them: gain, lag and delay, and the file that keeps them."""
