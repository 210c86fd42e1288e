"""Commands that a guard receives: the newest one, and when silence ends it."""

from __future__ import annotations

import math

from setcmas_expe.mocap.pose_track import StampClock

SILENCE_S = 0.3
"""Silence after a command to move at which the guard stops the robot, in s."""

LATEST_S = 0.2
"""Largest delay of a command that is followed, compared with the least seen, in s."""

REPEAT_S = 1.0
"""How long a guard whose base also listens to cmd_vel repeats zero after a silence, in s."""

STOP = (0.0, 0.0)

Velocities = tuple[float, float]


class Commands:
    """The commands of a robot; all times in s on a steady clock."""

    def __init__(
        self, now: float, silence_s: float = SILENCE_S, hears_itself: bool = True
    ) -> None:
        """Begin; the robot may be moving already although its commander is dead.

        A guard `hears_itself` if it commands zero on the topic that it listens to.
        """
        self._silence_s = silence_s
        self._hears_itself = hears_itself
        self._newest = (math.inf, 0.0)  # unknown
        self._received = now
        self.forget_clock()

    def forget_clock(self) -> None:
        """Compare delays anew: another computer, whose clock differs, may command the robot."""
        self._clock = StampClock()

    def is_late(self, stamp: float, now: float) -> bool:
        """Return whether a command comes too late to be followed, as where a network queues.

        Its stamp is in s on its sender's clock; 0 if unknown: then it is not.
        """
        return self._clock.lateness(stamp, now) > LATEST_S

    def receive(self, V: float, omega: float, now: float) -> None:
        """Take a command (m/s, rad/s); one that is not finite is one to move, and soon ends."""
        if self._hears_itself and (V, omega) == STOP and self.must_repeat_zero(now):
            return  # perhaps the guard's own zero
        if not (math.isfinite(V) and math.isfinite(omega)):
            if self._newest != STOP:
                return
            V, omega = math.inf, 0.0
        self._newest, self._received = (V, omega), now

    def have_ended(self, now: float) -> bool:
        """Return whether there is no command to follow."""
        return now - self._received >= self._silence_s or math.isinf(self._newest[0])

    def newest(self, now: float) -> Velocities:
        """Return the command to follow (m/s, rad/s); zero once they have ended."""
        return STOP if self.have_ended(now) else self._newest

    def must_repeat_zero(self, now: float) -> bool:
        """Return whether a robot was told to move, and then nothing more, a short time ago."""
        silent_for = now - self._received - self._silence_s
        return self._newest != STOP and 0.0 <= silent_for < REPEAT_S
