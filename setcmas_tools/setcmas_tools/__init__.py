"""Recording, CSV files and plots of runs of a fleet."""
