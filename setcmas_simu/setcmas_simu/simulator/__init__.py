"""The process of virtual robots."""
