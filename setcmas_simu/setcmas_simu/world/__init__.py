"""Surroundings of the robots: arena and obstacles."""
