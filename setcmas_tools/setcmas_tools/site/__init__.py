"""The web page where students write, run and check laws without installing anything."""
