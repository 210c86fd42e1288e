"""Reports of node processes to the launcher that started them."""
