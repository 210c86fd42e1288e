"""Classes: all submissions graded, several at a time, and what is done kept."""
