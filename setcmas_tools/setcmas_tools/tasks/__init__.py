"""Tasks that ship: waypoints, tracking, consensus, formations, alignment, coverage."""
