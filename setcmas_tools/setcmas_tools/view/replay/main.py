"""Page of a run that is over, or of two: it needs no ROS."""

from __future__ import annotations

import html
import queue
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import ceil, floor

import numpy as np

from setcmas_tools.replay.curves import Curve, curves, difference
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.run.run import Run, stem_of_script
from setcmas_tools.view.fleet_scene import FleetScene
from setcmas_tools.view.page.announcement import announce
from setcmas_tools.view.page.browser_options import BrowserOptions
from setcmas_tools.view.page.desktop import Opener
from setcmas_tools.view.page.keys import BACK, END, FASTER, FORTH, HOME, PLAY, SLOWER
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.replay.options import ReplayOptions
from setcmas_tools.view.replay.play import Play
from setcmas_tools.view.replay.robot_choice import RobotChoice
from setcmas_tools.view.replay.second_run import SecondRun
from setcmas_tools.view.replay.state import ReplayedState
from setcmas_tools.view.replay.time_bar import HEIGHT_PX, TimeBar

Wish = Callable[[float], None]
"""Done by the thread that draws; takes the time of a steady clock."""

_FRAME_S = 0.05
_ROUNDING = 1e-6
_FAR_S = 1.0  # of the run; where it goes on farther from before, trails are drawn anew


def show_runs(runs: Mapping[str, Run], browser: BrowserOptions, options: ReplayOptions) -> None:
    """Show a run, or a second one with it, on a page until Ctrl-C.

    Args:
        runs: One or two, by what they are called.
        browser: Where the page is served.
        options: What it shows at first.

    Raises:
        SetcmasError: The page cannot be served.
    """
    stop = threading.Event()
    before = {
        number: signal.signal(number, lambda *_: stop.set())
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    page = Page(browser.host, browser.port)
    try:
        view = ReplayView(page, runs, options)
        announce(page, browser)
        view.run(stop)
    finally:
        page.stop()
        for number, handler in before.items():
            signal.signal(number, handler)


class ReplayView:
    """Draws a run at the time that is wished for."""

    def __init__(self, page: Page, runs: Mapping[str, Run], options: ReplayOptions) -> None:
        """Build the page's content.

        Args:
            page: Where to draw.
            runs: One run, or two, by what they are called.
            options: What it shows at first.
        """
        self._page = page
        self._names = [html.escape(name) for name in runs]
        self._states = [ReplayedState(RunHistory(run)) for run in runs.values()]
        first = self._states[0]
        histories = [state.history for state in self._states]
        self._span = _span(histories)
        self._wishes: queue.SimpleQueue[Wish] = queue.SimpleQueue()
        at = self._span[0] if options.at is None else options.at
        self._play = Play(*self._span, at, time.monotonic())
        self._scene = FleetScene(page.server, first, None)
        self._scene.controls.covered_px = HEIGHT_PX
        controls = self._scene.controls
        self._second = (
            SecondRun(page.server, self._states[1], controls, options.beside)
            if len(runs) > 1
            else None
        )
        self._robot = RobotChoice(page.server, first, controls, self._second)
        self._bar = TimeBar(
            page.server.gui, self._span, _charted([*runs.values()]), self._buttons(), self._on_drag
        )
        self._t = np.nan
        self._trail_s = np.nan

    def run(self, stop: threading.Event) -> None:
        """Draw until it is asked to stop."""
        opener = Opener(self._page.url)
        while not stop.is_set():
            begin = time.monotonic()
            opener.look(self._page.has_viewers())
            self._do_wishes()
            self.show(self._play.at(begin))
            stop.wait(max(0.0, begin + _FRAME_S - time.monotonic()))

    def show(self, t: float) -> None:
        """Show a time of the run, in s."""
        far = not 0.0 <= t - self._t <= _FAR_S * max(1.0, self._play.speed)
        paused = self._play.paused
        said = f'replay {self._speed}{", held" if paused else ""}'
        for state in self._states:
            state.move_to(t, said, self._play.speed)
        trail_s = self._scene.controls.trail_s
        with self._page.server.atomic():
            if far or trail_s != self._trail_s:
                self._scene.drawing.retrace(self._states[0].past(trail_s))
                if self._second:
                    self._second.retrace(trail_s)
            self._t, self._trail_s = t, trail_s
            self._scene.update(t, at_once=paused)
            if self._second:
                self._second.update(t)
            self._robot.show(t)
            self._bar.show(t, self._text(t), paused)

    @property
    def _speed(self) -> str:
        return f'×{self._play.speed:g}'

    def _text(self, t: float) -> str:
        laws = [html.escape(stem_of_script(state.law)) for state in self._states]
        runs = [
            f'{name} ({law})' if law else name for name, law in zip(self._names, laws, strict=True)
        ]
        told = [f'<b>t = {t:.2f} s</b> of {self._span[1]:.1f} s', ', dashed: '.join(runs)]
        return ' · '.join([*told, self._speed])

    def _do_wishes(self) -> None:
        while not self._wishes.empty():
            self._wishes.get()(time.monotonic())

    def _on_drag(self, t: float) -> None:
        self._wishes.put(lambda now: self._play.seek(t, now))

    def _buttons(self) -> dict[str, Callable[[], None]]:
        play, (t0, t1) = self._play, self._span
        does: dict[str, Wish] = {
            PLAY: play.toggle,
            HOME: lambda now: play.seek(t0, now),
            END: lambda now: play.seek(t1, now),
            BACK: lambda now: play.step(-1, now),
            FORTH: lambda now: play.step(1, now),
            SLOWER: lambda now: play.faster(-1, now),
            FASTER: lambda now: play.faster(1, now),
        }
        return {name: partial(self._wishes.put, do) for name, do in does.items()}


def _charted(runs: Sequence[Run]) -> list[Curve]:
    apart = difference(*runs) if len(runs) == 2 else None
    found = [curve for run in runs for curve in curves(run)]
    return [apart, *found] if apart else found


def _span(histories: Sequence[RunHistory]) -> tuple[float, float]:
    """Return the begin and the end of the longest run in s, in whole hundredths."""
    begin = ceil(100 * min(history.t0 for history in histories) - _ROUNDING)
    end = floor(100 * max(history.t1 for history in histories) + _ROUNDING)
    return begin / 100, max(end, begin + 1) / 100
