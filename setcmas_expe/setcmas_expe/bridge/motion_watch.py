"""Watch over a fleet: robots that deviate from their commands, and robots identified by motion.

Motion proves which body is which robot: it crawls, and turns slowly, under motion capture.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping

from setcmas_expe.bridge.bridge_decision import RobotView
from setcmas_expe.bridge.motion_check import Deviation, MotionCheck
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.planar_pose import Pose, motion_between

CRAWL_M_S = 0.05
"""Forward speed of a robot that is not proved, in m/s."""

PROOF_M = 0.10
"""Distance in m that proves a robot, if it goes all of it as commanded."""

SLOW_TURN_RAD_S = 0.3
"""Turn rate of a robot until it has been seen to turn as commanded, in rad/s."""

PROOF_RAD = 0.3
"""Turn in rad that proves the axes of a body: under wrong ones a robot may drive straight."""

_CRAWL_RAD_S = 1.0  # once that turn is proved
_SHORTEST_TURN_S = 0.7  # time to notice a robot that moves out of its turn
_SPARE = 1.1  # for acceleration and delay


class Proving:
    """Lets unproved robots crawl in turns, so that their motions differ.

    Time is cut into turns, two for each binary digit of a robot's number: the robot may move in
    one of them. Any two robots differ in a digit, so that each moves while the other rests.

    Attributes:
        left: Distance in m that each unproved robot must still go, by number.
        left_to_turn: Angle in rad by which each robot must still turn, by number.
    """

    def __init__(self, robots: Iterable[int]) -> None:
        """Start with all robots of a lab; none is proved."""
        robots = list(robots)
        self._digits = (len(robots) - 1).bit_length()
        self._turn_s = max(_SHORTEST_TURN_S, _SPARE * PROOF_M / CRAWL_M_S / max(1, self._digits))
        self._time = 0.0
        self.left = dict.fromkeys(robots, PROOF_M)
        self.left_to_turn = dict.fromkeys(robots, PROOF_RAD)

    def go_on(self, seconds: float) -> None:
        """Advance the time of turns, while robots are not paused."""
        self._time += seconds

    def end(self, robot: int) -> None:
        """End the proof of a robot: another body may have its name."""
        self.left[robot], self.left_to_turn[robot] = PROOF_M, PROOF_RAD

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the part of the wanted speeds (m/s, rad/s) that a robot may drive."""
        if not (math.isfinite(V) and math.isfinite(omega)):
            return V, omega
        if robot in self.left and not self._has_turn(robot):
            return 0.0, 0.0
        fastest, fastest_turn = math.inf, math.inf
        if robot in self.left:
            fastest, fastest_turn = CRAWL_M_S, _CRAWL_RAD_S
        if robot in self.left_to_turn:
            fastest_turn = SLOW_TURN_RAD_S
        excess = max(1.0, abs(V) / fastest, abs(omega) / fastest_turn)
        return V / excess, omega / excess

    def went(self, robot: int, metres: float, radians: float) -> bool:
        """Note how far a robot went and turned as commanded; return whether it is proved now.

        Distance and angle are negative against the command.
        """
        if robot in self.left_to_turn:
            left = self.left_to_turn[robot] - radians
            self.left_to_turn[robot] = min(left, PROOF_RAD)  # swinging leaves no debt
            if self.left_to_turn[robot] <= 0.0:
                del self.left_to_turn[robot]
        if robot not in self.left:
            return False
        self.left[robot] -= metres
        if self.left[robot] > 0.0:
            return False
        del self.left[robot]
        return True

    def _has_turn(self, robot: int) -> bool:
        if not self._digits:
            return True
        digit, half = divmod(int(self._time / self._turn_s) % (2 * self._digits), 2)
        return (robot - 1) >> digit & 1 != half


_LASTS_S = 2.0
_OUT_OF_SIGHT_S = 0.8  # sooner than a carried body counts as settled
_CARRIED_M = 0.1
_CARRIED_RAD = 0.5
_RESTS_AFTER_S = 1.0  # of a pause
_UNEVEN_M = 0.25
_REPEATS_S = 0.1


class MotionWatch:
    """Checks the motion of each robot; all times in s on one steady clock.

    Motion proves which body is which robot. The proof ends when another body may have got the
    name of this one: while it was out of sight, or carried during a pause.

    Attributes:
        proving: What each robot may drive until its motion has proved which it is.
    """

    def __init__(
        self, robots: Collection[int], warn: Callable[[str], None], report: Callable[[str], None]
    ) -> None:
        """Start with robots at rest (numbers 1 to N); `warn` and `report` show messages."""
        self._checks = {robot: MotionCheck() for robot in robots}
        self.proving = Proving(robots)
        self._warn = warn
        self._report = report
        self._deviations: dict[int, tuple[str, float]] = {}
        self._uneven = ''
        self._announced: set[int] = set()
        self._stepped = math.inf
        self._paused_for = 0.0
        self._places: dict[int, Pose] = {}  # of robots that rest during a pause

    def see(self, views: Mapping[int, RobotView], now: float) -> None:
        """Judge the newest poses of all robots, by number."""
        proved, is_doubted = [], False
        for robot, check in self._checks.items():
            view = views[robot]
            if view.pose is None:
                continue
            if self._may_be_another(robot, view.pose, now - view.measured):
                self._end_proof(robot)
            # Poses that are rejected or repeated are reported as that.
            is_usable = not view.pose_fault and view.received - view.same_since < _REPEATS_S
            deviation = check.step(
                view.pose,
                view.measured if is_usable else -math.inf,
                now,
                robot in self.proving.left,
                robot in self.proving.left_to_turn,
            )
            if deviation and robot not in self._deviations:
                self._deviations[robot] = self._reason(robot, deviation), now
                is_doubted = True
            elif self.proving.went(robot, check.advanced, check.turned):
                proved.append(robot)
        if is_doubted:  # if names were exchanged, another robot has the wrong one, too
            self._forget_motion()
            self.end_proofs()
        elif proved:
            self._report(f'{robots_in_words(proved, "are")} identified by motion: full speed')
        self._uneven = _unevenness([view.height for view in views.values()])
        self._deviations = {
            robot: (why, since)
            for robot, (why, since) in self._deviations.items()
            if now - since < _LASTS_S
        }

    def is_proved(self, robot: int) -> bool:
        """Return whether motion has proved which body is this robot."""
        return robot not in self.proving.left

    def deviations(self) -> dict[int, str]:
        """Return how robots deviate from their commands, and what to check, by number."""
        uneven = dict.fromkeys(self._checks, self._uneven) if self._uneven else {}
        return uneven | {robot: why for robot, (why, _) in self._deviations.items()}

    def commanded(self, commands: Mapping[int, tuple[float, float]], now: float) -> None:
        """Note the commands of all robots (m/s, rad/s) from now on; none while paused."""
        step, self._stepped = max(0.0, now - self._stepped), now
        if commands and self._paused_for == 0.0:
            self.proving.go_on(step)
        if commands:
            self._paused_for = 0.0
            self._places.clear()
        else:
            self._paused_for += step
            self._deviations.clear()
            self._forget_motion()
        self._announce_crawl([robot for robot, (V, _) in commands.items() if V])
        for robot, check in self._checks.items():
            check.command(*commands.get(robot, (0.0, 0.0)), now)

    def end_proofs(self) -> None:
        """End all proofs: this process was stopped, or asleep with the laptop."""
        for robot in self._checks:
            self._end_proof(robot)

    def _end_proof(self, robot: int) -> None:
        self.proving.end(robot)
        self._announced.discard(robot)

    def _may_be_another(self, robot: int, pose: Pose, age: float) -> bool:
        """Return whether another body may have got a robot's name; age is that of its pose."""
        if age > _OUT_OF_SIGHT_S:
            return True
        if self._paused_for < _RESTS_AFTER_S:
            return False
        moved, turned = motion_between(self._places.setdefault(robot, pose), pose)
        return moved > _CARRIED_M or turned > _CARRIED_RAD

    def _forget_motion(self) -> None:
        for check in self._checks.values():
            check.forget()

    def _reason(self, robot: int, deviation: Deviation) -> str:
        """Return how a robot deviates from its commands, and what to check."""
        proved = self.is_proved(robot)
        why = '' if proved else self._mistaken(robot)
        axes_proved = proved and robot not in self.proving.left_to_turn
        return why or deviation.text(axes_proved)

    def _mistaken(self, robot: int) -> str:
        """Return which other robot's commands explain the motion; empty if none."""
        for other, check in self._checks.items():
            if other != robot and check.explains(self._checks[robot]):
                return f'moves as robot {other} should: are their names swapped?'
        return ''

    def _announce_crawl(self, moving: Collection[int]) -> None:
        new = self.proving.left.keys() - self._announced - self._deviations.keys()
        if not new or not self.proving.left.keys() & set(moving):
            return
        self._announced |= new
        way = f'{100 * PROOF_M:.0f} cm at a crawl, to verify which body is which robot'
        self._warn(f'{robots_in_words(sorted(new))}: {way}')


def _unevenness(bodies: Collection[float]) -> str:
    """Return why bodies at such heights (m) cannot be on one floor; empty if they can."""
    heights = [height for height in bodies if math.isfinite(height)]
    if not heights or max(heights) - min(heights) < _UNEVEN_M:
        return ''
    return (
        f'bodies are at heights from {min(heights):.2f} to {max(heights):.2f} m: is y_up wrong '
        'in the lab file?'
    )
