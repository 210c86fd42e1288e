"""Nodes that drive one robot each, with its model and its pause; and their stand-in."""
