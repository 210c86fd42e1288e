"""The process that records topics into a bag."""
