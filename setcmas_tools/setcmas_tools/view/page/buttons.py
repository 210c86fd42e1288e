"""Buttons of the page that command the robots."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import viser

_START_HZ = 10.0
_BIG = (
    '<style>[id="{}"]{{min-height:60px;font-size:19px;letter-spacing:1px}}'
    '[id="{}"]:disabled{{background:#7f1d1d;color:#fff}}</style>'
)


@dataclass(frozen=True)
class Actions:
    """What the buttons do.

    Attributes:
        pause: Pauses the robots (True), or starts those of a simulation (False).
        reset: Puts those of a simulation back to their start poses.
        stop: Is an emergency stop.
        start: Starts those of an experiment, again and again while the button is held, for a
            browser by its number; None if this page may not.
    """

    pause: Callable[[bool], None]
    reset: Callable[[], None]
    stop: Callable[[], None]
    start: Callable[[int | None], None] | None = None


class Buttons:
    """Two for a simulation, pause or start and reset; three for an experiment."""

    def __init__(self, gui: viser.GuiApi, actions: Actions, order: float) -> None:
        """Add them to a panel, from a place on; `show` makes those visible that are of use."""
        self._start_label = 'Start' if actions.start else 'Start: in the terminal only'
        self._paused = self._real = False
        self._stop = gui.add_button('EMERGENCY STOP', color='red', order=order, visible=False)
        self._stop.on_click(lambda _: actions.stop())
        uuid = self._stop._impl.uuid  # viser has no sizes of buttons
        gui.add_html(_BIG.format(uuid, uuid), order=order)
        self._pause = gui.add_button('Pause', color='red', order=order)
        self._pause.on_click(lambda _: actions.pause(self._real or not self._paused))
        self._start = gui.add_button(
            self._start_label, color='green', order=order, visible=False, disabled=True
        )
        if start := actions.start:
            self._start.on_hold(lambda event: start(event.client_id), callback_hz=_START_HZ)
        self._reset = gui.add_button(
            'Reset', color='gray', order=order, hint='all robots back to their start poses'
        )
        self._reset.on_click(lambda _: actions.reset())
        self._may_start = actions.start is not None

    def show(self, paused: bool, stopped: bool, real: bool, ended: bool) -> None:
        """Fit them to the robots: paused, in an emergency stop, real, there no more."""
        real = real or self._may_start  # also before and after there is anything of it
        self._paused, self._real = paused, real
        self._stop.visible = self._start.visible = real
        self._stop.disabled = stopped
        self._stop.label = 'STOPPED: press R twice' if stopped else 'EMERGENCY STOP'
        self._start.disabled = stopped or not self._may_start
        self._pause.label = 'Start' if paused and not real else 'Pause'
        self._pause.color = 'green' if paused and not real else 'orange' if real else 'red'
        self._pause.visible = real or not ended
        self._reset.visible = not real and not ended
