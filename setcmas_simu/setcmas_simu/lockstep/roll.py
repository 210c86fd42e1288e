"""Roll of the followers of a simulation in lockstep, with their answers."""

from __future__ import annotations

from collections.abc import Sequence

from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.lockstep.answer import NONE, Answer, Follower


class Roll:
    """Decides when simulated time may advance, and whom it waits for.

    At the start every robot needs a controller, and a recorder must be there if one is expected.
    Later time waits for the followers that are left; one controller is enough.
    """

    def __init__(self, robots: Sequence[int], recorded: bool, window_ns: int) -> None:
        """Start without followers.

        Args:
            robots: Numbers of the robots.
            recorded: Whether a recorder will follow.
            window_ns: How far a recorder may lag behind, in ns.
        """
        self._robots = set(robots)
        self._recorded = recorded
        self._window_ns = window_ns
        self._answers: dict[Follower, Answer] = {}
        self._begun = False

    def __len__(self) -> int:
        """Return the number of followers."""
        return len(self._answers)

    @property
    def controlled(self) -> set[int]:
        """The robots that have a controller."""
        return {robot for follower in self._answers for robot in follower.robots}

    def take(self, answer: Answer) -> None:
        """Store an answer."""
        if answer.leaves:
            self._answers.pop(answer.follower, None)
        else:
            self._answers[answer.follower] = answer

    def drop(self, late: Sequence[Answer]) -> None:
        """Remove followers that died without leaving."""
        for answer in late:
            self._answers.pop(answer.follower, None)

    def commanded(self) -> dict[int, int]:
        """Return the stamp in ns of the newest command sent to each robot."""
        return {
            robot: answer.commanded
            for answer in self._answers.values()
            if answer.commanded != NONE
            for robot in answer.follower.robots
        }

    def late(self, stamp: int, exactly: bool = False) -> list[Answer]:
        """Return the last answers of followers that have not finished with a time in ns.

        Args:
            stamp: The time of the newest states.
            exactly: Whether recorders, too, must have finished.
        """
        window = 0 if exactly else self._window_ns
        return [
            answer
            for answer in self._answers.values()
            # A stamp ahead of this time belongs to an earlier simulator.
            if not 0 <= stamp - answer.stamp <= (0 if answer.follower.robots else window)
        ]

    def missing(self, stamp: int) -> str:
        """Return the followers that are missing, as text; '' if time may advance."""
        without = sorted(self._robots - self.controlled)
        if not self._begun and without:
            return f'a controller of {robots_in_words(without)}'
        if without == sorted(self._robots):
            return 'a controller'
        if self._recorded and all(follower.robots for follower in self._answers):
            return 'the recorder'
        self._begun = self._begun or not self.late(stamp)
        return ''
