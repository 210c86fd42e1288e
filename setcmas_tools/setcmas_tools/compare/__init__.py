"""Comparison of runs, and identification of robots from them."""
