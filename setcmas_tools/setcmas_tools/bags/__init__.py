"""Bags: read, record and play them, and write their topics as CSV."""
