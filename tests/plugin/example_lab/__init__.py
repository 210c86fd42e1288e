"""One of each thing that a package may offer to setcmas."""
