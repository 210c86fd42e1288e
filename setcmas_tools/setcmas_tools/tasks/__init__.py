"""Tasks: waypoints, tracking, consensus, formations, alignment, coverage, resilience."""
