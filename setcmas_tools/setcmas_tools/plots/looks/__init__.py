"""Looks of plots and films: colours, sizes, fonts, formats of files."""
