"""Runs: folder, inputs, description and references."""
