"""The process that holds the controllers of a fleet."""
