"""Nodes that drive one robot each, its model, its pause, and their stand-in."""
