"""What `setcmas new` writes."""
