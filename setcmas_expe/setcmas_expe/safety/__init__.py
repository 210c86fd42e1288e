"""Safety: what may move, and who stops it."""
