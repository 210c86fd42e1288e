"""Other programs that show runs: layouts for Foxglove and PlotJuggler, a file for Rerun."""
