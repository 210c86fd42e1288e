"""Bundles with which platforms grade by themselves."""
