"""Page of a run, the only one: handed in as a file, served once finished, or live."""
