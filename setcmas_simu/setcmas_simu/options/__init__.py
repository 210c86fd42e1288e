"""Options told once: kinds of values, and groups of options."""
