"""Process that records topics into a bag."""
