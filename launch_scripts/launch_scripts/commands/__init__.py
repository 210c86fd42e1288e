"""The verbs of the setcmas command, one per file."""
