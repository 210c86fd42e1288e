"""Checks of a machine and a lab."""
