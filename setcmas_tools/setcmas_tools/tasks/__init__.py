"""Tasks: waypoints, tracking, consensus, alignment, formations, coverage."""
