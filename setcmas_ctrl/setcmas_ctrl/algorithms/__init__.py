"""Built-in control laws: what `setcmas ctrl --algo NAME` runs."""
