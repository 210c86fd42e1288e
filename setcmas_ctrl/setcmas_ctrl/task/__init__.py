"""The task that a control law tells of."""
