"""Lockstep: simulated time that waits for its followers."""
