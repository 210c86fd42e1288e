"""Reports of node processes to their launcher."""
