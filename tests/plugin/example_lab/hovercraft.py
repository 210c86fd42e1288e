"""The hovercraft: it follows commands slowly, and slides sideways in curves."""

import numpy as np

from setcmas_simu.robots.model import RobotModel, Shape, disc

LAG = 0.5  # s
GRIP = 1.0  # 1/s, decay rate of sideways sliding


class Hovercraft(RobotModel):
    """A first-order lag in speed and turn rate; its motion lags behind its heading."""

    shape = Shape(disc(0.15), disc(0.15), 0.12)  # outline, body and height in m

    def step(self, states, commands, Ts):
        """Return the states one period later."""
        x, y, theta, forward, left, omega = states
        forward = forward + Ts / LAG * (commands[0] - forward) + Ts * omega * left
        left = left - Ts * GRIP * left - Ts * omega * forward
        omega = omega + Ts / LAG * (commands[2] - omega)
        theta = theta + Ts * omega
        x = x + Ts * (forward * np.cos(theta) - left * np.sin(theta))
        y = y + Ts * (forward * np.sin(theta) + left * np.cos(theta))
        return np.stack([x, y, theta, forward, left, omega])


HOVERCRAFT = Hovercraft()
