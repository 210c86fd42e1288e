"""Readers of bags."""
