"""Report: a run as one page that opens without a server, and the same as PDF."""
