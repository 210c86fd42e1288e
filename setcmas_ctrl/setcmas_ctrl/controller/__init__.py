"""The controller process: start, step, and what it publishes."""
