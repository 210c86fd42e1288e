"""Layouts with which other programs show a recording: Foxglove, Lichtblick, PlotJuggler."""
