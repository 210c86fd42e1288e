"""State that the view shows."""
