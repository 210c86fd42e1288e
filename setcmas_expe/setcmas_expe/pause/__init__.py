"""Pause: keyboard, joystick and the node that starts and stops the fleet."""
