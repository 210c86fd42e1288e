"""Messages: polling of topics, fields in encoded bytes, classes by type name."""
