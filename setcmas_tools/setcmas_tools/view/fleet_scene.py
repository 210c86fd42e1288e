"""Picture of the whole fleet and its panel, drawn anew at every frame."""

from __future__ import annotations

import math

import numpy as np
import viser

from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_tools.run.run import stem_of_script
from setcmas_tools.view.fleet_drawing import FleetDrawing
from setcmas_tools.view.model.fleet_state import FleetState
from setcmas_tools.view.model.robot_states import OK
from setcmas_tools.view.page.buttons import Actions
from setcmas_tools.view.page.controls import Controls
from setcmas_tools.view.page.panel import RobotRow, panel_html
from setcmas_tools.view.scene.robot_mesh import drawn_size

_PANEL_PERIOD_S = 0.25
_AMBIENT = 1.7  # of pi, which three.js takes for full light
_SUN = np.array([-0.45, -0.35, 1.0])  # towards it


class FleetScene:
    """Draws what is known of a fleet on a page.

    Attributes:
        controls: The panel.
        drawing: What is in the scene.
    """

    def __init__(
        self, server: viser.ViserServer, state: FleetState, actions: Actions | None
    ) -> None:
        """Build the scene and the panel; without actions the robots cannot be commanded."""
        self._server = server
        self._state = state
        _light(server.scene)
        self.drawing = FleetDrawing(server.scene, state)
        self.controls = Controls(server, actions, drawn_size(real=False))
        self._told = -math.inf
        self._real = False

    def update(self, now: float, at_once: bool = False) -> None:
        """Draw the picture of a time in s; browsers get it in one piece.

        Args:
            now: The time.
            at_once: Whether the figures in the panel follow at once, or now and then.
        """
        with self._server.atomic():
            self._draw(now)
            if at_once or abs(now - self._told) >= _PANEL_PERIOD_S:
                self._told = now
                self._show_panel(now)

    def _draw(self, now: float) -> None:
        state = self._state
        if not state.ended:
            state.fleet.forget(now)
            state.markers.expire(now)
        if state.real != self._real:
            self._real = state.real
            self.controls.size = drawn_size(state.real)
        self.drawing.trail_s = self.controls.trail_s
        by_robot = self.drawing.update(now, self.controls.size)
        self.controls.half_m = self.drawing.ground.half_m
        self.controls.move_cameras(by_robot)

    def _show_panel(self, now: float) -> None:
        state = self._state
        fleet, paused = state.fleet, state.states.paused(now)
        lost = self.drawing.lost(now)
        columns = zip(fleet.robots, fleet.newest().T, fleet.speeds(), lost, strict=True)
        rows = [
            RobotRow(
                robot,
                float(speed),
                (float(pose[0]), float(pose[1]), float(pose[2])),
                *self._describe(robot, bool(silent), float(speed), now),
                bool(silent),
            )
            for robot, pose, speed, silent in columns
        ]
        run = 'paused' if paused else state.clock.describe(now)
        run = 'EMERGENCY STOP' if state.states.stopped else run
        if state.ended:
            run = 'run ended'
        elif unseen := sorted(set(state.announced) - set(fleet.robots)):
            run += f'; {robots_in_words(unseen, "are")} announced, but not seen'
        self.controls.title = self._title(now)
        text = panel_html(rows, run, state.clock.seconds(now), fleet.disagreement(lost))
        self.controls.show_figures(text)
        if self.controls.buttons:
            self.controls.buttons.show(paused, state.states.stopped, state.real, state.ended)
        self.controls.offer(fleet.robots)

    def _title(self, now: float) -> str:
        """Return what a picture of now is of, such as 'consensus, 8 robots, t = 12.3 s'."""
        law, robots = self._state.law, len(self._state.fleet.robots)
        seconds = self._state.clock.seconds(now)
        parts = [stem_of_script(law)] if law else []
        parts += [f'{robots} robot{"s" if robots != 1 else ""}']
        return ', '.join([*parts, *([f't = {seconds:.1f} s'] if seconds is not None else [])])

    def _describe(self, robot: int, lost: bool, speed: float, now: float) -> tuple[int, str]:
        if self._state.ended:
            return OK, 'at the end'
        return self._state.states.describe(robot, lost, speed, now)


def _light(scene: viser.SceneApi) -> None:
    """Light the scene such that faces that look up show their colour as it is."""
    scene.configure_environment_map(None)
    scene.configure_default_lights(False)
    scene.add_light_ambient('/lights/all_around', intensity=_AMBIENT)
    sun = _SUN / np.linalg.norm(_SUN)
    scene.add_light_directional(
        '/lights/sun', intensity=(np.pi - _AMBIENT) / sun[2], position=tuple(50 * sun)
    )
