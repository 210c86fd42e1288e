"""Tables of messages, as CSV."""
