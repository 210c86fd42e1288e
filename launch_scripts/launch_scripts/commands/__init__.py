"""The verbs of the setcmas command, one a file."""
