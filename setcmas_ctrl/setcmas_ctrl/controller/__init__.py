"""The process of controllers."""
