"""The terminal: output, keyboard, status."""
