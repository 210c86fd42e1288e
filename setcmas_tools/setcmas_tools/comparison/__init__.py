"""Comparison of runs: how far apart they are, and what differs between them."""
