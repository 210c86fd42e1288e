"""Formats that plots can be written in."""

FORMATS = ('png', 'pdf', 'svg')
"""File formats by their usual endings; PNG at 150 dpi, the others are vector graphics."""
