"""Safety filter between control laws and robots: barrier certificates."""
