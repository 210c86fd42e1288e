"""Grading: rubrics, and the marks that control scripts get by them."""
