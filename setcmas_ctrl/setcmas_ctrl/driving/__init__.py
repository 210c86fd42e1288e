"""Drives robots: poses, commands, models, pause, and zero for dead controllers."""
