"""Records of a fleet over time: poses and communication."""
