"""Virtual unicycle robots that stand in for TurtleBot3s."""

__version__ = '0.1.0'
