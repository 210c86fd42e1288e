"""Built-in tasks: waypoints, tracking, consensus, and two formations."""
