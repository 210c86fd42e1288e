"""Links: delay, lose and disturb messages, and hold the last state that each robot received."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.link_properties import (
    Channel,
    Words,
    happens,
    normal,
    streams_of,
    thresholds,
    word,
)
from setcmas_simu.arrays import Floats


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


Indices = NDArray[np.intp]
Objects = NDArray[np.object_]
Choice = slice | Indices | NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Routes:
    """Links from N senders to R receivers, sorted by sender.

    Attributes:
        senders: Columns of the senders, shape (n,).
        cells: Places of the links in a flattened matrix (R, N), shape (n,).
        held: Places of x, y, theta in a flattened array (R, 3, N), shape (3, n).
        delay: In s, shape (n,).
        loss: Thresholds of `happens`, shape (n,).
        noise: Standard deviations in m, shape (n,).
        streams: Streams of random words, shape (n,).
    """

    senders: Indices
    cells: Indices
    held: Indices
    delay: Floats
    loss: Words
    noise: Floats
    streams: Words

    @classmethod
    def of(cls, up: NDArray[np.bool_], channel: Channel, streams: Words) -> Routes:
        """Return the links in a mask; mask, channel and streams have the shape (R, N)."""
        senders, rows = np.nonzero(up.T)
        nb_robots = up.shape[1]
        return cls(
            senders,
            rows * nb_robots + senders,
            (3 * rows + np.arange(3)[:, None]) * nb_robots + senders,
            channel.delay[rows, senders],
            thresholds(channel.loss[rows, senders]),
            channel.noise[rows, senders],
            streams[rows, senders],
        )

    def __getitem__(self, which: Choice) -> Routes:
        return Routes(
            self.senders[which],
            self.cells[which],
            self.held[:, which],
            self.delay[which],
            self.loss[which],
            self.noise[which],
            self.streams[which],
        )

    def sent_by(self, senders: Indices, nb_senders: int) -> Routes:
        """Return the links from some of the senders, which are sorted."""
        if len(senders) == nb_senders:
            return self
        if len(senders) == 1:
            begin, end = np.searchsorted(self.senders, [senders[0], senders[0] + 1]).tolist()
            return self[begin:end]
        sending = np.zeros(nb_senders, dtype=bool)
        sending[senders] = True
        return self[np.flatnonzero(sending[self.senders])]


_SAME_TIME_S = 1e-9
_WORDS = 3  # random words for each message: loss, and two for noise
_OF_NOISE = np.array([[1], [2]])


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
        self, receivers: Sequence[int], channel: Channel, seed: int, holds_own: bool = False
    ) -> None:
        """Prepare links to some robots, by their sorted numbers; all links are down.

        With `holds_own`, receivers hold their own states, too.
        The random numbers of a message depend on seed, receiver and sender, on how many messages
        the sender sent before, and, for a state sent once more, on how often the link came up.
        """
        nb_robots = len(channel.delay)
        rows: Indices = np.array(receivers, dtype=np.intp) - 1
        self._receivers = rows
        self._channel = Channel(channel.delay[rows], channel.loss[rows], channel.noise[rows])
        self._is_lossy = bool(self._channel.loss.any())
        self._is_noisy = bool(self._channel.noise.any())
        self._streams = streams_of(seed, rows[:, None], np.arange(nb_robots))
        shape = (len(rows), nb_robots)
        self._up = np.zeros(shape, dtype=bool)
        self._adjacency: Floats | None = None
        self._routes = Routes.of(self._up, self._channel, self._streams)
        self._held = np.full((len(rows), 3, nb_robots), np.nan)
        self._flat_held = self._held.reshape(-1)
        own = 3 * np.arange(len(rows)) + np.arange(3)[:, None]
        self._own: Indices = own * nb_robots + rows
        self._holds_own = holds_own
        self.last_sent = np.full((3, nb_robots), np.nan)
        self._numbers = np.full(nb_robots, -1)
        self._times_up = np.zeros(shape, dtype=int)
        # A queue per delay: with equal delays, messages arrive in the order of sending.
        self._on_the_way: dict[float, deque[Messages]] = {
            delay: deque() for delay in np.unique(self._channel.delay).tolist()
        }
        self.counts = LinkCounts.zero(*shape)
        self._flat = LinkCounts(*(count.reshape(-1) for count in vars(self.counts).values()))
        self._all_received = False  # whether each link that is up has delivered a message
        self._contents: _Contents | None = None  # of states without content there is none

    def begin(self, adjacency: Floats) -> None:
        """Bring up the links of a graph at the start of the run."""
        self._wire(adjacency, self._wanted(adjacency))
        routes = self._routes[self._numbers[self._routes.senders] >= 0]
        self._flat_held[routes.held] = self._with_noise(routes)
        if self._contents:
            self._contents.held[routes.cells] = self._contents.sent[routes.senders]

    def connect(self, adjacency: Floats, now: float) -> None:
        """Bring links up and down to match a graph; `now` is in s on any steady clock."""
        if adjacency is self._adjacency:
            return
        wanted = self._wanted(adjacency)
        if np.array_equal(wanted, self._up):
            self._adjacency = adjacency
            return
        self._deliver(now)  # messages that arrived before a link goes down are not lost
        rows, senders = np.nonzero(self._up & ~wanted)
        self._held[rows, :, senders] = np.nan
        if self._contents:
            self._contents.held[rows * len(self._numbers) + senders] = None
        new = wanted & ~self._up & (self._numbers >= 0)
        self._times_up[new] += 1
        self._wire(adjacency, wanted)
        streams = streams_of(self._streams, self._times_up)
        self._carry(Routes.of(new, self._channel, streams), now)

    def send(self, senders: Sequence[int] | Indices, poses: Floats, now: float) -> None:
        """Send the poses (3, n) of n robots at a time in s; `senders` are their sorted columns."""
        self._deliver(now)
        columns: Indices = np.asarray(senders, dtype=np.intp)
        self._numbers[columns] += 1
        self.last_sent[:, columns] = poses
        if self._contents:
            self._contents.sent[columns] = self._contents.attached[columns]
        self._carry(self._routes.sent_by(columns, len(self._numbers)), now)

    def attach(self, sender: int, content: object) -> None:
        """Let the states of a sender, a column, carry content from the next one on."""
        self._contents = self._contents or _Contents.none(*self._up.shape)
        self._contents.attached[sender] = content

    def forget_contents(self) -> None:
        """Drop all contents, those on their way too."""
        self._contents = None
        for delay, queue in self._on_the_way.items():
            self._on_the_way[delay] = deque(one._replace(contents=None) for one in queue)

    def contents(self, receiver: int) -> dict[int, Any]:
        """Return the content last received by a receiver, a row, by the senders' columns."""
        if not self._contents:
            return {}
        held = self._contents.held.reshape(self._up.shape)[receiver]
        return {sender: one for sender, one in enumerate(held.tolist()) if one is not None}

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
        self._flat_held[self._own] = own
        return self._held

    def _wanted(self, adjacency: Floats) -> NDArray[np.bool_]:
        return np.asarray(adjacency[self._receivers] > 0)

    def _wire(self, adjacency: Floats, up: NDArray[np.bool_]) -> None:
        self._adjacency, self._up = adjacency, up
        self._routes = Routes.of(up, self._channel, self._streams)
        self._all_received = False

    def _deliver(self, now: float) -> None:
        for queue in self._on_the_way.values():
            while queue and queue[0].arrival <= now + _SAME_TIME_S:
                self._arrive(queue.popleft())

    def _carry(self, routes: Routes, now: float) -> None:
        """Send the senders' last states over links."""
        self._flat.sent[routes.cells] += 1
        lost = None
        if self._is_lossy:
            words = word(routes.streams, self._numbers[routes.senders] * _WORDS)
            lost = happens(words, routes.loss)
            self._flat.lost[routes.cells] += lost
        poses = self._with_noise(routes)
        carried = self._contents and self._contents.sent[routes.senders]
        for delay, queue in self._on_the_way.items():
            which = self._arriving(routes, lost, delay)
            cells, held = routes.cells[which], routes.held[:, which]
            contents = None if carried is None else carried[which]
            messages = Messages(now + delay, cells, held, poses[:, which], self._routes, contents)
            if delay:
                queue.append(messages)
            else:
                self._arrive(messages)

    def _arriving(self, routes: Routes, lost: NDArray[np.bool_] | None, delay: float) -> Choice:
        """Return the links on which messages arrive after a delay in s."""
        if len(self._on_the_way) == 1:
            return slice(None) if lost is None else (~lost).nonzero()[0]
        late: NDArray[np.bool_] = routes.delay == delay
        return late if lost is None else late & ~lost

    def _with_noise(self, routes: Routes) -> Floats:
        poses = self.last_sent[:, routes.senders]
        if self._is_noisy:
            words = word(routes.streams, self._numbers[routes.senders] * _WORDS + _OF_NOISE)
            poses[:2] += routes.noise * normal(words)
        return poses

    def _arrive(self, messages: Messages) -> None:
        arrival, cells, held, poses, routes, contents = messages
        counts = self._flat
        if routes is not self._routes:  # links may have gone down meanwhile
            up = self._up.reshape(-1)[cells]
            counts.lost[cells[~up]] += 1
            cells, held, poses = cells[up], held[:, up], poses[:, up]
            contents = None if contents is None else contents[up]
        if not self._all_received:
            counts.first[cells[np.isnan(counts.first[cells])]] = arrival
            self._all_received = not np.isnan(counts.first[self._routes.cells]).any()
        counts.last[cells] = arrival
        counts.received[cells] += 1
        self._flat_held[held] = poses
        if contents is not None and self._contents:
            self._contents.held[cells] = contents


class Messages(NamedTuple):
    """Messages that arrive together.

    Attributes:
        arrival: Time of arrival in s.
        cells: Their links, as in `Routes`, shape (n,).
        held: As in `Routes`, shape (3, n).
        poses: Transmitted poses: rows x, y in m and theta in rad, shape (3, n).
        routes: Links that were up at the time of sending.
        contents: Their contents, shape (n,); None if no robot has attached one.
    """

    arrival: float
    cells: Indices
    held: Indices
    poses: Floats
    routes: Routes
    contents: Objects | None


class _Contents(NamedTuple):
    """Contents of states; None for a state without.

    Attributes:
        attached: Those that the next states of the senders will carry, shape (N,).
        sent: Those of the last states sent, shape (N,).
        held: Those that the receivers hold, as `Routes.cells`, shape (R * N,).
    """

    attached: Objects
    sent: Objects
    held: Objects

    @classmethod
    def none(cls, nb_receivers: int, nb_senders: int) -> _Contents:
        """Return those of robots that have sent states only."""
        sizes = nb_senders, nb_senders, nb_receivers * nb_senders
        return cls(*(np.full(size, None, dtype=object) for size in sizes))
