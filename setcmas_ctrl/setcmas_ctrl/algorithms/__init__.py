"""Built-in control laws, for `--algo NAME`."""
