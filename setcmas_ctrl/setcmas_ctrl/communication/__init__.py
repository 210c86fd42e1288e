"""Communication between robots: graph, links, event triggering."""
