"""Experiments on real robots."""
