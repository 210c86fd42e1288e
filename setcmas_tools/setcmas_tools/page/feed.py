"""Messages of a live page, and a summary of earlier ones for each new browser."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

_HISTORY_S = 120.0
_EACH_S = 0.19
_MOST_BYTES = 6_000_000
Message = Mapping[str, Any]


class Feed:
    """The newest state, and poses of the last two minutes; memory is bounded.

    It is used by the thread of the server only.
    """

    def __init__(self) -> None:
        self._status: Message | None = None
        self._now = 0.0
        self._encoder = msgspec.json.Encoder()
        self._begin()

    def _begin(self) -> None:
        self._looks: dict[int, Any] = {}
        self._states: dict[int, Any] = {}
        self._shapes: dict[str, Any] = {}
        self._links: dict[tuple[int, int], Any] = {}
        self._frames: deque[tuple[float, bytes]] = deque()
        self._bytes = 0

    def take(self, messages: Sequence[Message]) -> bytes:
        """Remember messages; returns them encoded, as one."""
        for message in messages:
            self._take(message)
        return self._encoder.encode(messages)

    def _take(self, message: Message) -> None:
        kind = message['kind']
        if kind == 'begin':
            self._begin()
        elif kind == 'status':
            self._status = message
        elif kind == 'now':
            self._now = message['t']
        elif kind == 'frame':
            self._remember(message)
        elif kind == 'looks':
            self._looks |= {look['number']: look for look in message['robots']}
        elif kind == 'states':
            self._states |= {state[0]: state for state in message['states']}
        elif kind == 'shapes':
            for key, shape in message['shapes']:
                self._shapes.pop(key, None)
                if shape:
                    self._shapes[key] = shape
        elif kind == 'links':
            self._links |= {(change[1], change[2]): change for change in message['changes']}

    def _remember(self, frame: Message) -> None:
        frames, t = self._frames, float(frame['t'])
        if len(frames) > 1 and frames[-1][0] - frames[-2][0] < _EACH_S:
            self._bytes -= len(frames.pop()[1])
        encoded = self._encoder.encode(frame)
        frames.append((t, encoded))
        self._bytes += len(encoded)
        while frames and (t - frames[0][0] > _HISTORY_S or self._bytes > _MOST_BYTES):
            self._bytes -= len(frames.popleft()[1])

    def snapshot(self) -> bytes:
        """Return the summary for a new browser, encoded as one message."""
        t = self._frames[0][0] if self._frames else self._now
        links = sorted(link for link in self._links.values() if link[3])
        return self._encoder.encode([
            *([self._status] if self._status else []),
            {'kind': 'begin'},
            {'kind': 'looks', 'robots': [*self._looks.values()]},
            *(msgspec.Raw(encoded) for _, encoded in self._frames),
            {'kind': 'states', 't': t, 'states': [*self._states.values()]},
            {'kind': 'shapes', 't': t, 'shapes': [*self._shapes.items()]},
            {'kind': 'links', 'changes': links},
            {'kind': 'now', 't': self._now},
        ])  # fmt: skip
