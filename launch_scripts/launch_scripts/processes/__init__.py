"""Processes that the launcher starts and stops."""
