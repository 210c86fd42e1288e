"""Examination of a running lab: what arrives, how robots move, how long messages take."""
