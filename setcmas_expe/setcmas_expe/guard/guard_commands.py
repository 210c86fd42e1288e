"""Commands that a guard receives: the newest one, when silence ends it, how fast it may rise."""

from __future__ import annotations

import math

from setcmas_expe.mocap.pose_track import StampClock
from setcmas_simu.robots.model import VelocityLimits

SILENCE_S = 0.3
"""Silence after a command to move at which the guard stops the robot, in s."""

LATEST_S = 0.2
"""Largest lateness of a command, compared with the promptest ones, in s."""

REPEAT_S = 1.0
"""How long the guard repeats zero after a silence, in s."""

ENDED = 'its commands have ended'

Velocities = tuple[float, float]


class Commands:
    """The commands of one process; their stamps show how late they are."""

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        self._silence_s = silence_s
        self.forget()

    def forget(self) -> None:
        """Start again: another process has another clock."""
        self._clock = StampClock()
        self._newest = (0.0, 0.0)
        self._received = -math.inf
        self._late = 0.0

    def receive(self, V: float, omega: float, stamp: float, now: float) -> None:
        """Take a command (m/s, rad/s), unless it is late or not a number.

        Its stamp is in s on the sender's clock, 0 if unknown; `now` on a steady clock here.
        """
        self._late = self._clock.lateness(stamp, now)
        if self._late <= LATEST_S and math.isfinite(V) and math.isfinite(omega):
            self._newest, self._received = (V, omega), now

    def newest(self, now: float) -> Velocities | None:
        """Return the command to follow (m/s, rad/s); None if there is none."""
        return self._newest if now - self._received < self._silence_s else None

    @property
    def trouble(self) -> str:
        """Why there is no command to follow."""
        return f'its commands come {self._late:.1f} s late' if self._late > LATEST_S else ENDED


class StopOnSilence:
    """Stops a robot whose base listens to cmd_vel itself; all times in s on a steady clock.

    The guard also receives its own zeros, which never make it act.
    """

    def __init__(self, now: float, silence_s: float = SILENCE_S) -> None:
        self._silence_s = silence_s
        self._moving = True
        self._newest = (math.inf, 0.0)  # unknown
        self._received = now
        self._zero_until = -math.inf

    @property
    def commanded(self) -> Velocities:
        """The last command (m/s, rad/s); zero once the guard has stopped the robot."""
        return self._newest if self._moving else (0.0, 0.0)

    def receive(self, V: float, omega: float, now: float) -> None:
        """Take a command; one that is not finite may start a robot, but never keeps it going."""
        if V == 0.0 and omega == 0.0:
            self._moving = False
        elif not self._moving or (math.isfinite(V) and math.isfinite(omega)):
            self._moving = True
            self._newest = V, omega
            self._zero_until = -math.inf
            self._received = now

    def must_stop(self, now: float) -> bool:
        """Return whether to publish zero now."""
        if self._moving and now - self._received >= self._silence_s:
            self._moving = False
            self._zero_until = now + REPEAT_S
        return now < self._zero_until


def accelerated(
    wanted: Velocities, before: Velocities, limits: VelocityLimits, gain: float
) -> Velocities:
    """Return the part of a command that a robot may follow now, on the same curve.

    Args:
        wanted: Forward speed in m/s and turn rate in rad/s.
        before: The velocities that it follows now.
        limits: Its largest speeds; braking is never limited.
        gain: Largest gain in a wheel's speed, in m/s.
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
