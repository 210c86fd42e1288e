"""Robot that follows commands with a gain, a lag and a delay, as real robots do."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.options.kinds import MAX_RATE_HZ
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_simu.robots.velocity_limits import IDEAL, VelocityLimits

LONGEST_DELAY_S = 2.0
"""Largest delay of a robot that can be modelled."""

_LAGS = slice(6, 8)  # rows of a state after POSE and TWIST: the current speeds


@dataclass(frozen=True)
class Response:
    """How a speed follows its command: lag w' = gain u(t - delay) - w.

    Attributes:
        gain: Steady-state speed divided by the commanded speed.
        lag: Time constant in s; 0 is none.
        delay: Time in s between a command and its first effect.
    """

    gain: float = 1.0
    lag: float = 0.0
    delay: float = 0.0


class IdentifiedRobot(RobotModel):
    """Unicycle whose forward speed and turn rate each have a gain, a lag and a delay.

    A step solves the first-order lag with dead time (Astrom and Hagglund, Advanced PID Control,
    2006, section 2.4) for piecewise constant commands; the robot moves at its mean speeds.
    """

    shape = BURGER_SHAPE

    def __init__(
        self, forward: Response, turn: Response, limits: VelocityLimits = IDEAL, way: float = 0.0
    ) -> None:
        """Describe the robot.

        Args:
            forward: Response of the forward speed.
            turn: Response of the turn rate.
            limits: Limits of the commands.
            way: Transport delay in s of commands and poses between control law and robot.
        """
        self.forward, self.turn, self.limits, self.way = forward, turn, limits, way
        self.V_max = limits.V_max * max(1.0, forward.gain)
        delays = [forward.delay + way, turn.delay + way]
        self._slots = 2 + math.ceil(MAX_RATE_HZ * max(delays))  # commands may change at each step
        self._delays = np.array(delays)[:, None]
        self._gains = np.array([forward.gain, turn.gain])
        self._lags = np.maximum([forward.lag, turn.lag], 1e-9)

    def start(self, poses: Floats) -> Floats:
        """Return the states of robots at rest, whose earlier commands were zero."""
        states = np.zeros((8 + 3 * self._slots, poses.shape[1]))
        states[:3] = poses
        ages, _ = self._remembered(states)
        ages[:] = math.inf
        return states

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return the unicycle's commands, scaled down on the same curve as in an experiment."""
        commands = super().command(velocities, poses, komega)
        if self.limits is not IDEAL:
            commands[[0, 2]] = np.transpose(
                [self.limits.scaled_down(V, omega) for V, omega in commands[[0, 2]].T.tolist()]
            )
        return commands

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        later = states.copy()
        ages, remembered = self._remembered(later)
        self._remember(ages, remembered, np.array(self.limits.saturate(commands[0], commands[2])))
        means = np.empty((2, states.shape[1]))
        for row, (delay, gain, lag) in enumerate(
            zip(self._delays, self._gains, self._lags, strict=True)
        ):
            # Slot k, newest first, acts from begin[k] to end[k] of this period.
            begin = np.clip(delay - ages, 0.0, Ts)
            begin[-1] = 0.0
            end = np.vstack([np.full((1, begin.shape[1]), Ts), begin[:-1]])
            wanted = gain * remembered[row]
            before = states[_LAGS][row]
            shares = np.exp((end - Ts) / lag) - np.exp((begin - Ts) / lag)
            speed = before * math.exp(-Ts / lag) + np.sum(shares * wanted, axis=0)
            means[row] = (np.sum((end - begin) * wanted, axis=0) - lag * (speed - before)) / Ts
            later[_LAGS][row] = speed
        ages += Ts
        return unicycle.driven(later, means[0], means[1], Ts)

    def _remembered(self, states: Floats) -> tuple[Floats, Floats]:
        """Return views of the commands' ages in s, (K, N), and of their speeds, (2, K, N)."""
        ages, speeds = np.split(states[8:], [self._slots])
        return ages, speeds.reshape(2, self._slots, -1)

    def _remember(self, ages: Floats, remembered: Floats, commands: Floats) -> None:
        """Store commands, shape (2, N), that differ from the newest stored ones."""
        new = np.any(remembered[:, 0] != commands, axis=0)
        ages[1:, new], remembered[:, 1:, new] = ages[:-1, new], remembered[:, :-1, new]
        ages[0, new], remembered[:, 0, new] = 0.0, commands[:, new]
