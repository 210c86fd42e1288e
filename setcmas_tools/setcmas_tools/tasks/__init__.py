"""Tasks that ship: waypoints, tracking, consensus, alignment, and two formations."""
