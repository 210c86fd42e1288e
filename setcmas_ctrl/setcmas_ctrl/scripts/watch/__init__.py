"""Watch over scripts: slow calls, stuck calls, and saved files."""
