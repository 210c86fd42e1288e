"""Links: delay, lose and disturb messages, and hold the last state that each robot received."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Objects = NDArray[np.object_]


@dataclass(frozen=True)
class Channel:
    """Properties of all links.

    Attributes:
        delay: Delay of each message in s.
        loss: Probability that a message is lost.
        noise: Standard deviation of the noise on each coordinate of a received position, in m.
    """

    delay: float = 0.0
    loss: float = 0.0
    noise: float = 0.0


@dataclass
class LinkCounts:
    """Counts of messages on links; rows are receivers, columns are senders.

    Attributes:
        sent: Messages sent while the link was up.
        received: Messages that arrived.
        lost: Messages that were lost.
        first: Time of the first arrival in s; NaN if none.
        last: Time of the last arrival in s; NaN if none.
    """

    sent: NDArray[np.int64]
    received: NDArray[np.int64]
    lost: NDArray[np.int64]
    first: Floats
    last: Floats

    @classmethod
    def zero(cls, nb_receivers: int, nb_senders: int) -> LinkCounts:
        """Return counts before the first message."""
        shape = (nb_receivers, nb_senders)
        sent, received, lost = np.zeros((3, *shape), dtype=np.int64)
        first, last = np.full((2, *shape), np.nan)
        return cls(sent, received, lost, first, last)

    @property
    def mean_interval(self) -> Floats:
        """Mean time between arrivals in s; NaN for fewer than two."""
        intervals = np.where(self.received > 1, self.received - 1, np.nan)
        return (self.last - self.first) / intervals


class Messages(NamedTuple):
    """Messages of n senders that arrive together.

    Attributes:
        arrival: Time of arrival in s.
        senders: Columns of the senders, shape (n,).
        over: Mask of the links that carry these messages, shape (R, n).
        poses: Transmitted poses: rows x, y in m and theta in rad, shape (R, 3, n), or (1, 3, n)
            if they are the same for all receivers.
        contents: Contents of the messages, shape (n,); None for a state without content.
    """

    arrival: float
    senders: Indices
    over: Mask
    poses: Floats
    contents: Objects


_SAME_TIME_S = 1e-9


class Links:
    """The links on which R robots of one process receive the states of a fleet of N.

    A receiver holds the last state that it received from each sender (zero-order hold). It knows
    its own newest pose or, if it holds its own state, the pose that it sent last. Receivers
    know what robots sent before `begin`, as if it was sent long ago. When a link comes up later,
    the last state of the sender is sent over it once more: it is latched. A state may carry
    content, an object that shares its delay and its loss.

    Attributes:
        counts: Counts of messages since `begin`.
        last_sent: Last state sent by each robot: rows x, y, theta, shape (3, N); NaN for none yet.
    """

    def __init__(
        self,
        receivers: Sequence[int],
        nb_robots: int,
        channel: Channel,
        seed: int,
        holds_own: bool = False,
    ) -> None:
        """Prepare links to some robots of a fleet, by their sorted numbers; all links are down.

        With `holds_own`, receivers hold their own states, too. Each sender has its own random
        numbers, and draws some per message for every robot of the fleet. So what happens to a
        message does not depend on which other robots send or receive.
        """
        rows: Indices = np.array(receivers, dtype=np.intp) - 1
        shape = (len(rows), nb_robots)
        self._nb_robots, self._receivers = nb_robots, rows
        self._channel = channel
        is_random = channel.loss > 0.0 or channel.noise > 0.0
        self._random = [
            np.random.default_rng([seed, sender])
            for sender in range(nb_robots if is_random else 0)
        ]
        self._up: Mask = np.zeros(shape, dtype=bool)
        self._up_in_fleet: Mask = np.zeros((nb_robots, nb_robots), dtype=bool)
        self._adjacency: Floats | None = None
        self._held = np.full((len(rows), 3, nb_robots), np.nan)
        self._holds_own = holds_own
        self.last_sent = np.full((3, nb_robots), np.nan)
        self._on_the_way: deque[Messages] = deque()  # they arrive in the order of sending
        self.counts = LinkCounts.zero(*shape)
        self._has_contents = False
        self._attached, self._contents = np.full((2, nb_robots), None)  # of next and last states
        self._held_contents = np.full(shape, None)

    def begin(self, adjacency: Floats) -> None:
        """Bring up the links of a graph at the start of the run."""
        self._adjacency, self._up_in_fleet = adjacency, adjacency > 0
        self._up = self._up_in_fleet[self._receivers]
        poses = self._transmitted(np.arange(len(adjacency)))
        self._held[:] = np.where(self._up[:, None], poses, np.nan)
        self._held_contents[:] = self._contents
        self._held_contents[~self._up] = None

    def connect(self, adjacency: Floats, now: float) -> None:
        """Bring links up and down to match a graph; `now` is in s on any steady clock."""
        if adjacency is self._adjacency:
            return
        self._adjacency, wanted, before = adjacency, adjacency > 0, self._up_in_fleet
        if np.array_equal(wanted, before):
            return
        self._deliver(now)  # messages that arrived before a link goes down are not lost
        gone = (before & ~wanted)[self._receivers]
        new = wanted & ~before & np.isfinite(self.last_sent[0])
        self._up_in_fleet, self._up = wanted, wanted[self._receivers]
        self._held.swapaxes(1, 2)[gone] = np.nan
        self._held_contents[gone] = None
        senders = np.flatnonzero(new.any(axis=0))
        if len(senders):
            self._carry(senders, new[np.ix_(self._receivers, senders)], now)

    def send(self, senders: Sequence[int] | Indices, poses: Floats, now: float) -> None:
        """Send the poses (3, n) of n robots at a time in s; `senders` are their sorted columns."""
        self._deliver(now)
        columns: Indices = np.asarray(senders, dtype=np.intp)
        self.last_sent[:, columns] = poses
        self._contents[columns] = self._attached[columns]
        self._carry(columns, self._up[:, columns], now)

    def attach(self, sender: int, content: object) -> None:
        """Let the states of a sender, a column, carry content from the next one on."""
        self._has_contents = True
        self._attached[sender] = content

    def forget_contents(self) -> None:
        """Drop all contents, those on their way too."""
        on_the_way = [messages.contents for messages in self._on_the_way]
        for contents in (self._attached, self._contents, self._held_contents, *on_the_way):
            contents.fill(None)

    def contents(self, receiver: int) -> dict[int, Any]:
        """Return the content last received by a receiver, a row, by the senders' columns."""
        held = self._held_contents[receiver].tolist()
        return {sender: one for sender, one in enumerate(held) if one is not None}

    def known_poses(self, own_poses: Floats, now: float) -> Floats:
        """Return the poses that each receiver knows at a time in s.

        Args:
            own_poses: Newest poses of the receivers, shape (3, R).
            now: Not before the time of earlier calls.

        Returns:
            Shape (R, 3, N), NaN for unknown robots; valid until the next call.
        """
        self._deliver(now)
        own = self.last_sent[:, self._receivers] if self._holds_own else own_poses
        self._held[np.arange(len(self._receivers)), :, self._receivers] = own.T
        return self._held

    def _deliver(self, now: float) -> None:
        while self._on_the_way and self._on_the_way[0].arrival <= now + _SAME_TIME_S:
            self._arrive(self._on_the_way.popleft())

    def _carry(self, senders: Indices, over: Mask, now: float) -> None:
        """Send the last states of n senders over the links in a mask (R, n)."""
        self.counts.sent[:, senders] += over
        if self._channel.loss:
            draws = np.array([self._random[one].random(self._nb_robots) for one in senders])
            lost = over & (draws.T[self._receivers] < self._channel.loss)
            self.counts.lost[:, senders] += lost
            over = over & ~lost
        arrival = now + self._channel.delay
        messages = Messages(
            arrival, senders, over, self._transmitted(senders), self._contents[senders]
        )
        if self._channel.delay:
            self._on_the_way.append(messages)
        else:
            self._arrive(messages)

    def _transmitted(self, senders: Indices) -> Floats:
        """Return the last states of n senders, with noise, as in `Messages`."""
        poses = self.last_sent[None, :, senders]
        if not self._channel.noise:
            return poses
        of_fleet = (2, self._nb_robots)
        draws = np.array([self._random[one].standard_normal(of_fleet) for one in senders])
        noise = draws.transpose(2, 1, 0)[self._receivers] * self._channel.noise
        disturbed = np.repeat(poses, len(noise), axis=0)
        disturbed[:, :2] += noise
        return disturbed

    def _arrive(self, messages: Messages) -> None:
        arrival, senders, over, poses, contents = messages
        counts = self.counts
        arrived = over & self._up[:, senders]  # links may have gone down meanwhile
        counts.lost[:, senders] += over & ~arrived
        counts.received[:, senders] += arrived
        first, last = counts.first[:, senders], counts.last[:, senders]
        counts.first[:, senders] = np.where(arrived & np.isnan(first), arrival, first)
        counts.last[:, senders] = np.where(arrived, arrival, last)
        held = self._held[:, :, senders]
        self._held[:, :, senders] = np.where(arrived[:, None], poses, held)
        if self._has_contents:
            known = self._held_contents[:, senders]
            self._held_contents[:, senders] = np.where(arrived, contents, known)
