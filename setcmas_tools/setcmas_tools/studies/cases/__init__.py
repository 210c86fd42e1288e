"""Cases of a study: names and values that are varied, and the files that they name."""
