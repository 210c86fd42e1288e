"""Runs: what happened, how it ended, and the folder with its files."""
