"""Choice of a robot whose state is told: from a list, or by a click on it."""

from __future__ import annotations

import numpy as np
import viser

from setcmas_simu.arrays import Floats
from setcmas_tools.view.page.controls import Controls
from setcmas_tools.view.replay.robot_text import robot_html
from setcmas_tools.view.replay.state import ReplayedState

_NONE = 'click one'
_ORDER = 0.5  # between the figures and the choices of the view
_NEAR_M = 0.35  # of a robot in its true size times 2


class RobotChoice:
    """A list of robots, and below it what is known of the chosen one."""

    def __init__(
        self, server: viser.ViserServer, state: ReplayedState, controls: Controls
    ) -> None:
        """Add the list to the panel."""
        self._state, self._controls = state, controls
        self._names = {f'robot {robot}': robot for robot in state.history.robots}
        gui = server.gui
        self._list = gui.add_dropdown('Robot', (_NONE, *self._names), order=_ORDER)
        self._text = gui.add_html('', order=_ORDER)
        server.scene.on_click()(self._on_click)
        self._shown: tuple[str, float] | None = None

    def show(self, t: float) -> None:
        """Tell of the chosen robot at a time in s."""
        wanted = str(self._list.value), t
        if wanted == self._shown:
            return
        self._shown = wanted
        robot = self._names.get(wanted[0])
        if robot is None:
            self._text.content = ''
            return
        one = self._state.instants.of(robot, t)
        self._text.content = robot_html(one, self._true_poses(one.called_at or t))

    def _true_poses(self, t: float) -> Floats:
        history = self._state.history
        result = np.full((3, history.robots[-1]), np.nan)
        result[:, np.array(history.robots) - 1] = history.newest(t)
        return result

    def _on_click(self, event: viser.SceneClickEvent) -> None:
        """Choose the robot nearest to where a click meets the ground."""
        origin, along = np.array(event.ray_origin), np.array(event.ray_direction)
        if along[2] >= 0 or not self._state.fleet.robots:
            return
        place = (origin - along * origin[2] / along[2])[:2]
        distances = np.hypot(*(self._state.fleet.newest()[:2].T - place).T)
        nearest = int(np.argmin(distances))
        if distances[nearest] <= _NEAR_M * self._controls.size / 2:
            name = f'robot {self._state.fleet.robots[nearest]}'
            self._list.value = name  # type: ignore[misc]  # it has a setter
