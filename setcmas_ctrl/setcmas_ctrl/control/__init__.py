"""Control laws, and the maths between a law and its robot."""
