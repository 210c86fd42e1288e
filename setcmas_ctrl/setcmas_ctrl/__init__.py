"""Distributed control laws for fleets of unicycles, and how they run."""
