"""Cases of a study: varied names, their values, and the files that they name."""
