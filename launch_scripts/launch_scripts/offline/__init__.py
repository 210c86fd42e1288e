"""The process of an offline run."""
