"""Users' scripts: loading, settings, calls, output and errors."""
