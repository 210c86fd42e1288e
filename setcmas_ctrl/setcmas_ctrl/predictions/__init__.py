"""Predictions: what theory says of the built-in laws."""
