"""Lockstep: a simulation whose time goes on when all that follow it have answered."""
