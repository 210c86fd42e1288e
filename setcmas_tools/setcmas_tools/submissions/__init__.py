"""Submissions of a class: files, students, scripts, similarity."""
