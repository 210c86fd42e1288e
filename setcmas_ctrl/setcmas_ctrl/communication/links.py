"""Imperfect links: messages under way, and what each robot has heard last."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.channel import Channel
from setcmas_ctrl.communication.link_counts import LinkCounts
from setcmas_simu.arrays import Floats

Indices = NDArray[np.intp]

_SAME_TIME_S = 1e-9


class Links:
    """The links on which the robots of one process hear the fleet.

    A receiver holds what it has heard last of each sender (zero-order hold). What robots have
    sent before `begin` is known to those who hear them, as if sent long ago. When a link comes up
    later, the last state of the sender is sent over it once more: it is latched.

    Attributes:
        counts: What went over the links since `begin`.
    """

    def __init__(self, receivers: Sequence[int], channel: Channel, seed: int) -> None:
        """Prepare links that are all down.

        Args:
            receivers: Numbers of the R robots that hear, sorted.
            channel: The links of the fleet of N robots.
            seed: Chooses the random numbers; those of a message depend on nothing else but
                receiver, sender, how many the sender has sent before, and, for a state that is
                sent once more, how often the link has come up.
        """
        self._nb_robots = len(channel.delay)
        self._receivers: Indices = np.array(receivers, dtype=np.intp) - 1
        self._channel = Channel(
            channel.delay[self._receivers],
            channel.loss[self._receivers],
            channel.noise[self._receivers],
        )
        self._seed = seed
        shape = (len(receivers), self._nb_robots)
        self._up = np.zeros(shape, dtype=bool)
        self._held = np.full((len(receivers), 3, self._nb_robots), np.nan)
        self._last_sent = np.full((3, self._nb_robots), np.nan)
        self._numbers = np.full(self._nb_robots, -1)
        self._times_up = np.zeros(shape, dtype=int)
        # A queue for each delay: within one, messages arrive in the order in which they were sent.
        delays = np.unique(self._channel.delay)
        self._on_the_way: dict[float, deque[tuple[float, Indices, Indices, Floats]]] = {
            float(delay): deque() for delay in delays[delays > 0]
        }
        self.counts = LinkCounts.zero(*shape)

    @property
    def last_sent(self) -> Floats:
        """What each robot has sent last: rows x, y, theta, shape (3, N); NaN for nothing yet."""
        return self._last_sent

    def begin(self, adjacency: Floats) -> None:
        """Bring up the links of a graph, at the start of the run; adjacency has shape (N, N)."""
        self._up = self._wanted(adjacency)
        senders, rows = np.nonzero(self._up.T & (self._numbers >= 0)[:, None])
        _, noise = self._draws(rows, senders)
        self._hold(rows, senders, self._as_heard(rows, senders, noise))

    def connect(self, adjacency: Floats, now: float) -> None:
        """Bring links up and down as a graph wants it; `now` is in s on any steady clock."""
        wanted = self._wanted(adjacency)
        if np.array_equal(wanted, self._up):
            return
        self._deliver(now)  # what has arrived before a link goes down is not lost
        rows, senders = np.nonzero(self._up & ~wanted)
        self._held[rows, :, senders] = np.nan
        senders, rows = np.nonzero((wanted & ~self._up).T & (self._numbers >= 0)[:, None])
        self._up = wanted
        self._times_up[rows, senders] += 1
        times_up = self._times_up[rows, senders]
        for count in np.unique(times_up).tolist():
            alike = times_up == count
            self._carry(rows[alike], senders[alike], now, count)

    def send(self, senders: Sequence[int] | Indices, poses: Floats, now: float) -> None:
        """Take messages that robots broadcast.

        Args:
            senders: Columns of the robots that send, sorted.
            poses: Their poses: rows x, y in m and theta in rad, shape (3, number of senders).
            now: Time in s.
        """
        self._deliver(now)
        columns: Indices = np.asarray(senders, dtype=np.intp)
        self._numbers[columns] += 1
        self._last_sent[:, columns] = poses
        which, rows = np.nonzero(self._up[:, columns].T)
        self._carry(rows, columns[which], now)

    def heard(self, own_poses: Floats, now: float) -> Floats:
        """Return the poses that each receiver knows at a time, its own one exactly.

        Args:
            own_poses: Poses of the receivers, shape (3, R).
            now: Time in s, not before that of earlier calls.

        Returns:
            Shape (R, 3, N), NaN for robots that are not heard; valid until the next call.
        """
        self._deliver(now)
        self._held[np.arange(len(self._receivers)), :, self._receivers] = own_poses.T
        return self._held

    def _deliver(self, now: float) -> None:
        for queue in self._on_the_way.values():
            while queue and queue[0][0] <= now + _SAME_TIME_S:
                arrival, rows, senders, poses = queue.popleft()
                self._arrive(rows, senders, poses, arrival)

    def _wanted(self, adjacency: Floats) -> NDArray[np.bool_]:
        return np.asarray(adjacency[self._receivers] > 0)

    def _carry(self, rows: Indices, senders: Indices, now: float, times_up: int = 0) -> None:
        """Send the last state of senders over links, given in the order of the senders.

        Args:
            rows: The receivers.
            senders: The senders.
            now: Time in s.
            times_up: How often these links have come up, if the states are sent once more.
        """
        self.counts.sent[rows, senders] += 1
        uniform, noise = self._draws(rows, senders, times_up)
        lost = uniform < self._channel.loss[rows, senders]
        self.counts.lost[rows[lost], senders[lost]] += 1
        rows, senders, noise = rows[~lost], senders[~lost], noise[:, ~lost]
        poses = self._as_heard(rows, senders, noise)
        delays = self._channel.delay[rows, senders]
        at_once = delays == 0
        self._arrive(rows[at_once], senders[at_once], poses[:, at_once], now)
        for delay, queue in self._on_the_way.items():
            late = delays == delay
            queue.append((now + delay, rows[late], senders[late], poses[:, late]))

    def _as_heard(self, rows: Indices, senders: Indices, noise: Floats) -> Floats:
        poses = self._last_sent[:, senders]
        poses[:2] += self._channel.noise[rows, senders] * noise
        return poses

    def _draws(self, rows: Indices, senders: Indices, times_up: int = 0) -> tuple[Floats, Floats]:
        """Return a number uniform in [0, 1), shape (n,), and two normal ones, (2, n), per link."""
        uniform, normal = np.ones(len(rows)), np.zeros((2, len(rows)))
        if not (self._channel.is_random and len(rows)):
            return uniform, normal
        begins = np.flatnonzero(np.diff(senders, prepend=-1)).tolist()
        for begin, end in zip(begins, [*begins[1:], len(senders)], strict=True):
            sender = int(senders[begin])
            # A generator for each message: its numbers do not depend on what came before.
            generator = np.random.Generator(
                np.random.Philox(
                    key=[self._seed, sender],
                    counter=[0, int(self._numbers[sender]), times_up, 0],
                )
            )
            receivers = self._receivers[rows[begin:end]]
            uniform[begin:end] = generator.random(self._nb_robots)[receivers]
            normal[:, begin:end] = generator.standard_normal((2, self._nb_robots))[:, receivers]
        return uniform, normal

    def _arrive(self, rows: Indices, senders: Indices, poses: Floats, now: float) -> None:
        up = self._up[rows, senders]
        if not up.all():  # the link went down meanwhile
            self.counts.lost[rows[~up], senders[~up]] += 1
            rows, senders, poses = rows[up], senders[up], poses[:, up]
        counts = self.counts
        new = counts.received[rows, senders] == 0
        counts.first[rows[new], senders[new]] = now
        counts.last[rows, senders] = now
        counts.received[rows, senders] += 1
        self._hold(rows, senders, poses)

    def _hold(self, rows: Indices, senders: Indices, poses: Floats) -> None:
        self._held[rows, :, senders] = poses.T
