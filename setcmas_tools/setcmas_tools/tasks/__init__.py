"""Tasks that ship: waypoints, tracking, consensus, and two formations."""
