"""The fleet: names, topics, colours and poses of the robots."""
