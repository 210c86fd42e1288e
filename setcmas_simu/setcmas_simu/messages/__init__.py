"""Messages: polled instead of called back, read from their bytes, found by their type."""
