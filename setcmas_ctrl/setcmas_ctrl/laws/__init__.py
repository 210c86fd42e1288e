"""Laws and other scripts of users: loading, settings, errors, calls, output."""
