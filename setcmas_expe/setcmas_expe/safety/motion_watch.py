"""Watch over a fleet: robots that deviate from their commands, and robots proved by motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.safety.body_proofs import CRAWL_M_S, PROOF_M, Proofs, Proving
from setcmas_expe.safety.motion_check import Deviation, MotionCheck
from setcmas_simu.fleet.fleet import robots_in_words

_LASTS_S = 2.0


class MotionWatch:
    """Checks the motion of each robot; all times in s on one steady clock."""

    def __init__(
        self, robots: Collection[int], proofs: Proofs | None, warn: Callable[[str], None]
    ) -> None:
        """Start with robots at rest.

        Args:
            robots: Their numbers, 1 to N.
            proofs: Earlier proofs; None to use and keep none, as in an emulated lab.
            warn: Shows a message to the user.
        """
        self._checks = {robot: MotionCheck() for robot in robots}
        self._proofs = proofs
        self._proving = Proving(robots, proofs.proved() if proofs else ())
        self._warn = warn
        self._troubles: dict[int, tuple[str, float]] = {}
        self._announced: set[int] = set()
        self._stepped: float | None = None

    def see(
        self,
        tracks: Mapping[int, PoseTrack],
        wheels: Mapping[int, tuple[float, float] | None],
        now: float,
    ) -> None:
        """Judge the newest poses.

        Args:
            tracks: The track of each robot.
            wheels: Forward speed by its odometry in m/s and the time of arrival; None before.
            now: Time in s.
        """
        proved = []
        for robot, check in self._checks.items():
            track, rolls = tracks[robot], wheels[robot]
            if rolls:
                check.note_wheels(*rolls)
            if track.pose is None:
                continue
            # The track judges poses that are rejected or repeated.
            seen = -math.inf if track.fault or track.repeats else track.received
            crawls = robot in self._proving.left
            deviation = check.step(track.pose, seen, crawls, now)
            if deviation and robot not in self._troubles:
                self._doubt(robot, deviation, now)
            elif self._proving.went(robot, check.advanced):
                proved.append(robot)
        if proved:
            self._keep(proved)
        self._troubles = {
            robot: (why, since)
            for robot, (why, since) in self._troubles.items()
            if now - since < _LASTS_S
        }

    def keep_nothing(self) -> None:
        """Keep no proofs: the robots are emulated, and only their names are those of real ones."""
        self._proofs = None

    def is_proved(self, robot: int) -> bool:
        """Return whether motion has proved which body is this robot."""
        return robot not in self._proving.left

    def trouble(self, robot: int) -> str:
        """Return how a robot's motion deviates, and what to check; empty if it does not."""
        return self._troubles.get(robot, ('', 0.0))[0]

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the part of the wanted speeds (m/s, rad/s) that a robot may drive."""
        return self._proving.allowed(robot, V, omega)

    def commanded(self, commands: Mapping[int, tuple[float, float]], now: float) -> None:
        """Note the commands of all robots (m/s, rad/s) from now on; none while paused."""
        step = 0.0 if self._stepped is None else now - self._stepped
        self._stepped = now if commands else None
        self._proving.go_on(step)
        if not commands:
            self._troubles.clear()
            for check in self._checks.values():
                check.forget()
        self._announce_crawl([robot for robot, (V, _) in commands.items() if V])
        for robot, check in self._checks.items():
            check.command(*commands.get(robot, (0.0, 0.0)), now)

    def _doubt(self, robot: int, deviation: Deviation, now: float) -> None:
        proved = self.is_proved(robot)
        why = '' if proved else self._mistaken(robot)
        self._troubles[robot] = why or deviation.text(proved), now
        self._checks[robot].forget()
        self._proving.doubt(robot)
        self._announced.discard(robot)
        if self._proofs:
            self._stored(lambda proofs: proofs.drop(robot))

    def _mistaken(self, robot: int) -> str:
        """Return which other robot's commands explain the motion; empty if none."""
        for other, check in self._checks.items():
            if other != robot and check.explains(self._checks[robot]):
                return f'moves as robot {other} should: are their names exchanged?'
        return ''

    def _announce_crawl(self, moving: Collection[int]) -> None:
        new = self._proving.left.keys() - self._announced - self._troubles.keys()
        if not new or not self._proving.left.keys() & set(moving):
            return
        self._announced |= new
        turns = ', in turns' if len(self._checks) > 1 else ''
        self._warn(
            f'{robots_in_words(sorted(new))} crawl'
            f'{"s" if len(new) == 1 else ""} at {CRAWL_M_S:g} m/s for {100 * PROOF_M:.0f} cm'
            f'{turns}, to prove which body is which robot'
            f'{"; others wait" if self._proving.others_wait else ""}'
        )

    def _keep(self, robots: list[int]) -> None:
        self._warn(f'{robots_in_words(robots, "are")} proved by motion: full speed')
        if self._proofs:
            self._stored(lambda proofs: proofs.add(robots))

    def _stored(self, change: Callable[[Proofs], None]) -> None:
        assert self._proofs
        try:
            change(self._proofs)
        except OSError as error:
            self._warn(f'cannot keep the proofs for the next run: {error}')
