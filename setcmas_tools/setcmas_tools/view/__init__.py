"""Browser view of a running fleet."""
