"""Exercises: control laws whose maths students fill in (`--exercise`)."""
