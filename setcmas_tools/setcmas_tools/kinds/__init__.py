"""Kinds of things that packages may add: metrics, plots and tasks."""
