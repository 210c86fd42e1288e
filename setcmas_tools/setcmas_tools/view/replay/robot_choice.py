"""Choice of a robot whose state is told: from a list, or by a click on it."""

from __future__ import annotations

import numpy as np
import viser

from setcmas_simu.arrays import Floats
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.view.page.controls import Controls
from setcmas_tools.view.replay.robot_text import robot_html
from setcmas_tools.view.replay.second_run import SecondRun
from setcmas_tools.view.replay.state import ReplayedState

_NONE = 'click one'
_SECOND = ' of the second run'
_ORDER = 0.5  # between the figures and the choices of the view
_NEAR_M = 0.35  # of a robot in its true size times 2


class RobotChoice:
    """A list of robots, and below it what is known of the chosen one."""

    def __init__(
        self,
        server: viser.ViserServer,
        state: ReplayedState,
        controls: Controls,
        second: SecondRun | None = None,
    ) -> None:
        """Add the list of the robots of a run, or of two, to the panel."""
        self._state, self._controls, self._second = state, controls, second
        self._names = {_name(robot): (state, robot) for robot in state.history.robots}
        if second:
            theirs = second.state
            self._names |= {_name(r, _SECOND): (theirs, r) for r in theirs.history.robots}
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
        if wanted[0] not in self._names:
            self._text.content = ''
            return
        state, robot = self._names[wanted[0]]
        one = state.instants.of(robot, t)
        called = t if one.called_at is None else one.called_at
        self._text.content = robot_html(one, _true_poses(state.history, called))

    def _on_click(self, event: viser.SceneClickEvent) -> None:
        """Choose the robot nearest to where a click meets the ground."""
        origin, along = np.array(event.ray_origin), np.array(event.ray_direction)
        if along[2] >= 0:
            return
        place = (origin - along * origin[2] / along[2])[:2]
        fleets = [(self._state, 0.0, '')]
        if self._second:
            fleets.append((self._second.state, self._second.offset_m, _SECOND))
        found = []
        for state, offset_m, which in fleets:
            shown = state.fleet.newest()[:2].T + np.array([offset_m, 0.0])
            distances = np.hypot(*(shown - place).T).tolist()
            names = (_name(robot, which) for robot in state.fleet.robots)
            found += list(zip(distances, names, strict=True))
        distance, name = min(found, default=(np.inf, _NONE))
        if distance <= _NEAR_M * self._controls.size / 2:
            self._list.value = name  # type: ignore[misc]  # it has a setter


def _name(robot: int, which: str = '') -> str:
    return f'robot {robot}{which}'


def _true_poses(history: RunHistory, t: float) -> Floats:
    """Return the poses of all robots by their numbers from 1."""
    result = np.full((3, history.robots[-1]), np.nan)
    result[:, np.array(history.robots) - 1] = history.newest(t)
    return result
