"""Drawing by control scripts, which import these modules by their bare names."""
