"""Templates for `setcmas new`."""
