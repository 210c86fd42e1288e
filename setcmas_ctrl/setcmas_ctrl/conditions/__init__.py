"""Triggering conditions of the literature, for `--event-triggered --ctc NAME`."""
