"""Scenario of a run, in files and in Python."""
