"""Processes that make the runs of a study, on this machine or on a cluster."""
