"""Identification: what gain, lag and delay the robots of an experiment have."""
