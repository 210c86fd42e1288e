"""Submissions: found in what learning platforms download, and compared with each other."""
