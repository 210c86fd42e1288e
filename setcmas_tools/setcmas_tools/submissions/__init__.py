"""Submissions of a class: files, students, scripts, similarity, and the sandbox for them."""
