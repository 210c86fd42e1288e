"""Reports of an experiment: robots that are stopped and why, diagnostics, the arena in RViz."""
