"""Commands that reach a guard: the newest one, when silence ends it, how fast it may rise."""

from __future__ import annotations

import math

from setcmas_expe.mocap.pose_track import StampClock
from setcmas_simu.robots.model import VelocityLimits

SILENCE_S = 0.3
"""Silence in s, after a command to move, from which the guard stops the robot."""

LATEST_S = 0.2
"""By how much a command may come later than the promptest ones, in s."""

ENDED = 'its commands have ended'

Velocities = tuple[float, float]


class Commands:
    """The commands of one source.

    How late one comes is judged by its stamp. The clocks of two machines differ, so the least
    difference between arrival and stamp that was seen stands for a command that came at once.
    """

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        """Begin without any."""
        self._silence_s = silence_s
        self.forget()

    def forget(self) -> None:
        """Begin anew: with another source, another clock."""
        self._clock = StampClock()
        self._newest = (0.0, 0.0)
        self._heard = -math.inf
        self._late = 0.0

    def hear(self, V: float, omega: float, stamp: float, now: float) -> None:
        """Take a command; one that is late, or not a number, is not followed.

        Args:
            V: Forward speed in m/s.
            omega: Turn rate in rad/s.
            stamp: When it was sent, in s on the sender's clock; 0 if it does not tell.
            now: Time in s on a steady clock.
        """
        self._late = self._clock.lateness(stamp, now)
        if self._late <= LATEST_S and math.isfinite(V) and math.isfinite(omega):
            self._newest, self._heard = (V, omega), now

    def newest(self, now: float) -> Velocities | None:
        """Return what to follow (m/s, rad/s); None if there is nothing that may be."""
        return self._newest if now - self._heard < self._silence_s else None

    @property
    def trouble(self) -> str:
        """Why there is nothing to follow."""
        return f'its commands come {self._late:.1f} s late' if self._late > LATEST_S else ENDED


REPEAT_S = 1.0
"""For how long the guard repeats zero, in s."""


class StopOnSilence:
    """Follows the commands of one robot; all times in s on a steady clock.

    The guard hears its own zeros like anybody's; since a zero never makes it act, they need not
    be told apart.
    """

    def __init__(self, now: float, silence_s: float = SILENCE_S) -> None:
        """Begin at a time: for all that is known, the robot moves, and nobody commands it."""
        self._silence_s = silence_s
        self._moving = True
        self._heard = now
        self._zero_until = -math.inf

    @property
    def moving(self) -> bool:
        """Whether the last command was to move, and nobody has stopped the robot since."""
        return self._moving

    def hear(self, V: float, omega: float, now: float) -> None:
        """Take a command; one that is not finite may move a robot, but never keeps it going."""
        if V == 0.0 and omega == 0.0:
            self._moving = False
        elif not self._moving or (math.isfinite(V) and math.isfinite(omega)):
            self._moving = True
            self._zero_until = -math.inf
            self._heard = now

    def must_stop(self, now: float) -> bool:
        """Return whether zero is to be published now."""
        if self._moving and now - self._heard >= self._silence_s:
            self._moving = False
            self._zero_until = now + REPEAT_S
        return now < self._zero_until


def ramped(
    wanted: Velocities, before: Velocities, limits: VelocityLimits, gain: float
) -> Velocities:
    """Return the part of a command that a robot may follow now, on the same curve.

    Args:
        wanted: Forward speed in m/s and turn rate in rad/s.
        before: What it follows now.
        limits: Its largest speeds; to lose speed is never held back.
        gain: By how much a wheel may gain speed, in m/s.
    """
    V, omega = limits.scaled_down(*wanted)
    share = 1.0
    for speed, last in zip(_wheels(V, omega, limits), _wheels(*before, limits), strict=True):
        reach = gain + (abs(last) if last * speed > 0 else 0.0)
        if abs(speed) > reach:
            share = min(share, reach / abs(speed))
    return share * V, share * omega


def _wheels(V: float, omega: float, limits: VelocityLimits) -> Velocities:
    half = 0.5 * limits.wheel_separation * omega
    return V - half, V + half
