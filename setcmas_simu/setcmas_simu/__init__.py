"""Simulated robots in place of TurtleBot3s."""

__version__ = '0.1.0'
