"""Scenario: what is to be run."""
