"""After the marking: tables for learning platforms, corrections, and what students are given."""
