"""Plausibility: measured motion against what was commanded, and proofs of who is who."""
