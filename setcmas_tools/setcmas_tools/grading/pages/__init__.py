"""HTML pages of a graded class, and its table on the screen."""
