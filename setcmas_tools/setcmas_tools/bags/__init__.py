"""Bags: read, record and play them."""
