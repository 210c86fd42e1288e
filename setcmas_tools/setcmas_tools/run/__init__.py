"""Runs: the scenario to be run, what happened, how it ended, and the folder with its files."""
