"""Nodes of experiments."""
