"""The setcmas command."""
