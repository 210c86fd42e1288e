"""Exercises: control laws whose maths is left to fill in (`--exercise`)."""
