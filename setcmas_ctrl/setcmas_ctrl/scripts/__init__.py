"""Users' scripts: load, call, watch, and report their failures."""
