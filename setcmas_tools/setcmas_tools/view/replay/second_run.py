"""The second run of a page: ghosts over the first one, or a fleet of its own beside it."""

from __future__ import annotations

import viser

from setcmas_tools.view.fleet_drawing import FleetDrawing
from setcmas_tools.view.page.controls import Controls
from setcmas_tools.view.replay.state import ReplayedState

_ROOT, _FLOOR = '/second', '/second/floor'
_GHOSTS, _BESIDE = 'as ghosts', 'beside'
_ORDER = 0.6  # below the choice of a robot
_APART = 2.35  # in halves of the ground's side
_THIN = 0.4


class SecondRun:
    """Draws the second run, and lets people choose where."""

    def __init__(
        self, server: viser.ViserServer, state: ReplayedState, controls: Controls, beside: bool
    ) -> None:
        """Add the choice to the panel.

        Args:
            server: Of the page.
            state: The second run.
            controls: Tells how the first one is shown.
            beside: Where it is shown at first.
        """
        self.state, self._controls = state, controls
        scene = server.scene
        self._frame = scene.add_frame(_ROOT, show_axes=False)
        self._floor = scene.add_frame(_FLOOR, show_axes=False)
        self._drawing = FleetDrawing(scene, state, _ROOT, _FLOOR)
        self._drawing.trails.width = _THIN
        self._choice = server.gui.add_button_group('Second run', (_GHOSTS, _BESIDE), order=_ORDER)
        self._beside = beside
        self._choice.on_click(lambda event: self._place(event.target.value == _BESIDE))

    @property
    def offset_m(self) -> float:
        """How far to the right of the first run it is drawn, in m."""
        return _APART * self._controls.half_m if self._beside else 0.0

    def retrace(self, trail_s: float) -> None:
        """Draw trails of another time."""
        self._drawing.retrace(self.state.past(trail_s))

    def update(self, t: float) -> None:
        """Draw a time in s."""
        self._controls.beside_m = self.offset_m
        self._frame.position = (self.offset_m, 0.0, 0.0)
        self._floor.visible = self._beside
        self._drawing.robots.ghosts = not self._beside
        self._drawing.trail_s = self._controls.trail_s
        self._drawing.update(t, self._controls.size)

    def _place(self, beside: bool) -> None:
        self._beside = beside
