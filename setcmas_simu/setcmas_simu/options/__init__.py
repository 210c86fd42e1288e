"""Options: kinds of values, and groups of options."""
