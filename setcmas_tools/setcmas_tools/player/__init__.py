"""Process that plays a recording: what was there is published again, commands never."""
