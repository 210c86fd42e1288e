"""Runs at an instant: where robots were, what they knew, what happened to them."""
