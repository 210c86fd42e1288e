"""Practical sessions; the names of their files end with the number of the session."""
