"""Supervision of processes: started, read, blamed, and ended with all their children."""
