"""Watch over a fleet: robots that deviate from their commands, and robots identified by motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.mocap.sample import Pose
from setcmas_expe.safety.body_identity import CRAWL_M_S, PROOF_M, Proving
from setcmas_expe.safety.motion_check import Deviation, MotionCheck
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.planar_pose import wrap_angle

_LASTS_S = 2.0
_OUT_OF_SIGHT_S = 0.8  # sooner than a carried body counts as settled
_CARRIED_M = 0.1
_CARRIED_RAD = 0.5
_RESTS_AFTER_S = 1.0  # of a pause
_UNEVEN_M = 0.5


class MotionWatch:
    """Checks the motion of each robot; all times in s on one steady clock.

    Motion proves which body is which robot. The proof ends when another body may have got the
    name of this one: while it was out of sight, or carried during a pause.
    """

    def __init__(
        self,
        robots: Collection[int],
        warn: Callable[[str], None],
        report: Callable[[str], None],
    ) -> None:
        """Start with robots at rest (numbers 1 to N); `warn` and `report` show messages."""
        self._checks = {robot: MotionCheck() for robot in robots}
        self._proving = Proving(robots)
        self._warn = warn
        self._report = report
        self._troubles: dict[int, tuple[str, float]] = {}
        self._uneven = ''
        self._announced: set[int] = set()
        self._stepped: float | None = None
        self._paused_since: float | None = None
        self._places: dict[int, Pose] = {}  # of robots that rest during a pause

    def see(
        self,
        tracks: Mapping[int, PoseTrack],
        wheels: Mapping[int, tuple[float, float] | None],
        now: float,
    ) -> None:
        """Judge the newest poses; wheels give forward speed (m/s) and time of arrival."""
        proved = []
        for robot, check in self._checks.items():
            track, rolls = tracks[robot], wheels[robot]
            if rolls:
                check.note_wheels(*rolls)
            if track.pose is None:
                continue
            if self._may_be_another(robot, track.pose, track, now):
                self._end_proof(robot)
            # The track judges poses that are rejected or repeated.
            seen = -math.inf if track.fault or track.repeats else track.received
            crawls = robot in self._proving.left
            turns_slowly = robot in self._proving.left_to_turn
            deviation = check.step(track.pose, seen, now, crawls, turns_slowly)
            if deviation and robot not in self._troubles:
                self._doubt(robot, deviation, now)
            elif self._proving.went(robot, check.advanced, check.turned):
                proved.append(robot)
        if proved:
            self._report(f'{robots_in_words(proved, "are")} identified by motion: full speed')
        self._uneven = _unevenness([tracks[robot] for robot in self._checks])
        self._troubles = {
            robot: (why, since)
            for robot, (why, since) in self._troubles.items()
            if now - since < _LASTS_S
        }

    def is_proved(self, robot: int) -> bool:
        """Return whether motion has proved which body is this robot."""
        return robot not in self._proving.left

    def trouble(self, robot: int) -> str:
        """Return how a robot's motion deviates, and what to check; empty if it does not."""
        return self._troubles.get(robot, (self._uneven, 0.0))[0]

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the part of the wanted speeds (m/s, rad/s) that a robot may drive."""
        return self._proving.allowed(robot, V, omega)

    def commanded(self, commands: Mapping[int, tuple[float, float]], now: float) -> None:
        """Note the commands of all robots (m/s, rad/s) from now on; none while paused."""
        step = 0.0 if self._stepped is None else now - self._stepped
        self._stepped = now if commands else None
        self._proving.go_on(step)
        if commands:
            self._paused_since = None
            self._places.clear()
        else:
            self._paused_since = now if self._paused_since is None else self._paused_since
            self._troubles.clear()
            for check in self._checks.values():
                check.forget()
        self._announce_crawl([robot for robot, (V, _) in commands.items() if V])
        for robot, check in self._checks.items():
            check.command(*commands.get(robot, (0.0, 0.0)), now)

    def end_proofs(self) -> None:
        """End all proofs: this process was stopped, or asleep with the laptop."""
        for robot in self._checks:
            self._end_proof(robot)

    def _end_proof(self, robot: int) -> None:
        self._proving.end(robot)
        self._announced.discard(robot)

    def _may_be_another(self, robot: int, pose: Pose, track: PoseTrack, now: float) -> bool:
        """Return whether another body may have got a robot's name."""
        if track.age(now) > _OUT_OF_SIGHT_S:
            return True
        if self._paused_since is None or now - self._paused_since < _RESTS_AFTER_S:
            return False
        x, y, theta = self._places.setdefault(robot, pose)
        turned = abs(float(wrap_angle(pose[2] - theta)))
        return math.hypot(pose[0] - x, pose[1] - y) > _CARRIED_M or turned > _CARRIED_RAD

    def _doubt(self, robot: int, deviation: Deviation, now: float) -> None:
        proved = self.is_proved(robot)
        why = '' if proved else self._mistaken(robot)
        axes_proved = proved and robot not in self._proving.left_to_turn
        self._troubles[robot] = why or deviation.text(axes_proved), now
        self._checks[robot].forget()
        self._proving.doubt(robot)
        self._announced.discard(robot)

    def _mistaken(self, robot: int) -> str:
        """Return which other robot's commands explain the motion; empty if none."""
        for other, check in self._checks.items():
            if other != robot and check.explains(self._checks[robot]):
                return f'moves as robot {other} should: are their names swapped?'
        return ''

    def _announce_crawl(self, moving: Collection[int]) -> None:
        new = self._proving.left.keys() - self._announced - self._troubles.keys()
        if not new or not self._proving.left.keys() & set(moving):
            return
        self._announced |= new
        turns = ', one at a time' if len(self._checks) > 1 else ''
        self._warn(
            f'{robots_in_words(sorted(new))} crawl'
            f'{"s" if len(new) == 1 else ""} at {CRAWL_M_S:g} m/s for {100 * PROOF_M:.0f} cm'
            f'{turns}, to verify which body is which robot'
            f'{"; the others wait" if self._proving.others_wait else ""}'
        )


def _unevenness(tracks: Collection[PoseTrack]) -> str:
    """Return why robots cannot all be on one floor; empty if they can."""
    heights = [track.height for track in tracks if track.height is not None]
    if not heights or max(heights) - min(heights) < _UNEVEN_M:
        return ''
    return (
        f'bodies are at heights from {min(heights):.2f} to {max(heights):.2f} m: is y_up wrong '
        'in the lab file?'
    )
