"""Communication of an offline run: the nodes' own links and conditions, without ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.communication_settings import Communication
from setcmas_ctrl.communication.graph import GraphChanges
from setcmas_ctrl.communication.links import Links
from setcmas_ctrl.communication.message_content import Content, Value
from setcmas_ctrl.communication.triggering_conditions import CONSEQUENCE, have_gone_far
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_simu.arrays import Floats
from setcmas_simu.script_calls import Function
from setcmas_tools.offline import run_progress
from setcmas_tools.run.communication_record import (
    CommunicationRecord,
    Counts,
    SentMessage,
    record_of,
)


class OfflineCommunication:
    """Messages between the robots of a simulated fleet.

    Attributes:
        is_on: Whether there are links. Robots that know all poses have none until a law uses
            messages.
        t: Time of the current calls in s.
        sent: Messages that laws have sent.
        reports: Errors of triggering conditions.
    """

    def __init__(
        self, communication: Communication, nb_robots: int, warn: Callable[[str], None]
    ) -> None:
        """Load triggering conditions, or raise SetcmasError; `warn` shows when one fails."""
        robots = range(1, nb_robots + 1)
        self.is_on = not communication.is_ideal
        self.t = 0.0
        self.sent: list[SentMessage] = []
        self._communication = communication
        self.reports = ErrorReports(warn, CONSEQUENCE, function=Function.CONDITION)
        self._broadcasts = (
            [communication.broadcast(robot, self.reports) for robot in robots]
            if communication.event_triggered and communication.options.ctc is not None
            else []
        )
        self._nb_robots = nb_robots
        self._all = np.arange(nb_robots)
        self._poses: Floats = np.full((3, nb_robots), np.nan)
        self._times: list[float] = []
        self._triggered: list[NDArray[np.bool_]] = []
        self._changes = GraphChanges(nb_robots)
        self._begun = False

    @cached_property
    def _links(self) -> Links:
        return self._communication.links(range(1, self._nb_robots + 1))

    def measure(self, poses: Floats, V: Floats, t: float) -> None:
        """Send the states of the robots whose conditions trigger at time t (s).

        The states are poses (3, N) in m and rad, and forward speeds V (N,) in m/s.
        """
        if not self._communication.event_triggered:
            self._links.send(self._all, poses, t)
            return
        self._times.append(t)
        if self._broadcasts:
            triggered = self._triggered_by_scripts(poses, V, t)
        else:
            triggered = have_gone_far(
                poses, self._links.last_sent, self._communication.options.threshold
            )
        self._triggered.append(triggered)
        senders = triggered.nonzero()[0]
        if len(senders):
            self._links.send(senders, poses[:, senders], t)

    def _triggered_by_scripts(self, poses: Floats, V: Floats, t: float) -> NDArray[np.bool_]:
        states = zip(self._broadcasts, poses.T.tolist(), V.tolist(), strict=True)
        call = run_progress.current.call
        results: list[bool] = []
        for one, (x, y, theta), speed in states:
            call.begin(len(results) + 1, one.path, Function.CONDITION)
            results.append(one.is_triggered((x, y, theta), speed, t))
        call.end()
        return np.array(results)

    def known_poses(self, poses: Floats, t: float) -> tuple[Iterable[Floats], Floats | None]:
        """Return the poses that each robot knows at time t (s), and the adjacency matrix.

        Poses (3, N) are NaN for robots from which it receives nothing. Without links all robots
        know all poses, and there is no matrix.
        """
        self._poses, self.t = poses, t
        if not self.is_on:
            return repeat(poses), None
        adjacency = self._communication.graph.adjacency(t, poses[:2])
        if self._begun:
            self._links.connect(adjacency, t)
        else:
            self._links.begin(adjacency)
        self._changes.note(t if self._begun else 0.0, adjacency)
        self._begun = True
        known = self._links.known_poses(poses, t)
        for one, received, weights in zip(self._broadcasts, known, adjacency, strict=False):
            one.see(received, poses, weights)
        return known, adjacency

    def begin(self) -> None:
        """Let there be links, over which the robots have sent their poses already."""
        if not self.is_on:
            self.is_on = True
            self._links.send(self._all, self._poses, self.t)
            self.known_poses(self._poses, self.t)

    def send(self, robot: int, value: Value) -> None:
        """Let the next states that a robot sends carry a value."""
        self.sent.append(SentMessage(self.t, robot, value))
        self._links.attach(robot - 1, Content(self.t, value))

    def received(self, robot: int) -> Mapping[int, Content]:
        """Return what a robot has received last, by the numbers of the senders."""
        contents = self._links.contents(robot - 1) if self.is_on else {}
        return {sender + 1: content for sender, content in contents.items()}

    def record(self, times: Floats) -> CommunicationRecord | None:
        """Return the record of all messages, for robots with states at these times (s).

        None if there were no links.
        """
        if not self.is_on:
            return None
        counts = self._links.counts
        was_up = counts.sent > 0
        for _, receiver, sender, _ in self._changes.rows:
            was_up[receiver - 1, sender - 1] = True
        columns = counts.sent, counts.received, counts.lost, counts.mean_interval
        links = {
            (i + 1, j + 1): Counts(*(column[i, j].item() for column in columns))
            for i, j in np.argwhere(was_up).tolist()
        }
        sent = np.array(self._triggered, dtype=float).reshape(-1, self._nb_robots)
        evaluated = np.array(self._times)
        robots = np.tile(np.arange(1.0, self._nb_robots + 1), len(evaluated))
        triggers = np.column_stack(
            [np.repeat(evaluated, self._nb_robots), robots, sent.reshape(-1, 1)]
        )
        broadcasts = dict.fromkeys(range(1, self._nb_robots + 1), times)
        return record_of(links, triggers, self._changes.rows, broadcasts)
