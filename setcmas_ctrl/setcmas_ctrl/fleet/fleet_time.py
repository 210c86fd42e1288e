"""Time t of a fleet's laws, the same in all controller processes."""

from __future__ import annotations

_SAME_S = 0.02  # between machines, a message takes some of it
_RECENT_S = 1.0


class FleetTime:
    """Begins at 0 with the first process, and never goes back; who comes later joins.

    Processes tell each other their t, and who hears of a later one takes it over. A message takes
    time, so that what is heard is never ahead of its sender: no two of them can push each other
    on, and the clocks of the machines need not agree. All times `now` are of one clock, in s.
    """

    def __init__(self) -> None:
        """Wait for the first step."""
        self._zero: float | None = None  # when t was 0, had it never been held
        self._stepped = 0.0
        self._held = False
        self._heard_zero = 0.0
        self._heard_at = -float('inf')
        self._is_clocks = False

    def at(self, now: float) -> float:
        """Return t, in s: 0 before the first step, and what it was then since a held one."""
        if self._zero is None:
            return 0.0
        return (self._stepped if self._held else now) - self._zero

    def step(self, now: float, held: bool) -> float:
        """Go on to a step, in which t stands still if it is held; return t."""
        if self._zero is None:
            self._zero = self._heard_zero if self.is_shared(now) else now
        elif held:
            self._zero += now - self._stepped
        self._stepped, self._held = now, held
        return now - self._zero

    def hear(self, t: float, now: float) -> None:
        """Take what another process says that t is."""
        if self._is_clocks:
            return
        self._heard_zero, self._heard_at = now - t, now
        if self._zero is not None and (lead := t - self.at(now)) > _SAME_S:
            self._zero -= lead

    def follow_clock(self) -> None:
        """Let t be the time of the clock: other processes have the same one."""
        self._zero, self._is_clocks = 0.0, True

    def is_shared(self, now: float) -> bool:
        """Return whether another process was heard of lately."""
        return now - self._heard_at < _RECENT_S

    def begin_anew(self) -> None:
        """Let t begin with the next step: at 0, or where that of the other processes is."""
        self._zero = None
