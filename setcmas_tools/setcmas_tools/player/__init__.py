"""Process that plays a recording, without its commands."""
