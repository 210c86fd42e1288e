"""Picture of the whole fleet, drawn anew at every frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import viser
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_tools.run.run import stem_of_script
from setcmas_tools.view.model.communication import Flashes, Pairs
from setcmas_tools.view.model.fleet_view import FleetView
from setcmas_tools.view.model.marker_store import MarkerStore
from setcmas_tools.view.model.robot_states import OK, RobotStates
from setcmas_tools.view.model.run_clock import RunClock
from setcmas_tools.view.model.trails import Trails
from setcmas_tools.view.page.buttons import Actions
from setcmas_tools.view.page.controls import Controls
from setcmas_tools.view.page.panel import RobotRow, panel_html
from setcmas_tools.view.scene.ground_scene import HALF_M, LAB_HALF_M, GroundScene
from setcmas_tools.view.scene.link_scene import LinkScene
from setcmas_tools.view.scene.marker_scene import MarkerScene
from setcmas_tools.view.scene.robot_scene import RobotScene
from setcmas_tools.view.scene.trail_scene import TrailScene

_PANEL_PERIOD_S = 0.25
_SIMULATED_SIZE, _TRUE_SIZE = 2.5, 1.0
_AMBIENT = 1.7  # of pi, which three.js takes for full light
_SUN = np.array([-0.45, -0.35, 1.0])  # towards it
NO_PAIRS: Pairs = np.empty((0, 2), np.int64)


@dataclass
class FleetState:
    """What is known of a fleet.

    Attributes:
        announced: Numbers of the robots that there are said to be.
        models: Names of the models of robots whose model is announced.
        real: Whether this is an experiment, so that robots cannot be reset.
        ended: Whether nobody tells of robots any more; what was known last stays.
        law: The control law, as far as somebody tells.
        begun: How many runs have begun after another one.
        both: Robot numbers of communication links that go both ways, shape (E, 2).
        one_way: Of links that go one way, sender first, shape (F, 2).
    """

    fleet: FleetView = field(default_factory=FleetView)
    states: RobotStates = field(default_factory=RobotStates)
    clock: RunClock = field(default_factory=RunClock)
    markers: MarkerStore = field(default_factory=MarkerStore)
    flashes: Flashes = field(default_factory=Flashes)
    both: Pairs = field(default_factory=lambda: NO_PAIRS)
    one_way: Pairs = field(default_factory=lambda: NO_PAIRS)
    announced: list[int] = field(default_factory=list)
    models: dict[int, str] = field(default_factory=dict)
    real: bool = False
    ended: bool = False
    law: str = ''
    begun: int = 0

    def begin(self) -> None:
        """Forget the run that has ended: another one begins."""
        self.fleet, self.states, self.clock = FleetView(), RobotStates(), RunClock()
        self.markers.clear()
        self.both, self.one_way = NO_PAIRS, NO_PAIRS
        self.ended, self.law = False, ''
        self.begun += 1


class FleetScene:
    """Draws what is known of a fleet on a page."""

    def __init__(
        self, server: viser.ViserServer, state: FleetState, actions: Actions | None
    ) -> None:
        """Build the scene and the panel; without actions the robots cannot be commanded."""
        self._server = server
        self._state = state
        scene = server.scene
        _light(scene)
        self._ground = GroundScene(scene)
        self._robots = RobotScene(scene)
        self._trails, self._trail_scene = Trails(), TrailScene(scene)
        self._links = LinkScene(scene)
        self._markers = MarkerScene(scene)
        self.controls = Controls(server, actions, _SIMULATED_SIZE)
        self._next_panel = 0.0
        self._begun = 0
        self._real = self._clear = False

    def clear_trails(self) -> None:
        """Forget the trails: robots have been put somewhere else."""
        self._clear = True  # by the thread that draws

    def remember(self, now: float) -> None:
        """Let trails grow, whether somebody looks or not."""
        fleet = self._state.fleet
        self._trails.extend(now, fleet.robots, fleet.poses(now)[:2], fleet.take_put())

    def update(self, now: float) -> None:
        """Draw the picture of a time in s; browsers get it in one piece."""
        with self._server.atomic():
            self._draw(now)

    def _draw(self, now: float) -> None:
        state = self._state
        if not state.ended:
            state.fleet.forget(now)
            state.markers.expire(now)
        robots, poses = state.fleet.robots, state.fleet.poses(now)
        flashes = state.flashes.strength(robots, now)
        by_robot = dict(zip(robots, map(tuple, poses.T.tolist()), strict=True))
        self._reach(poses)
        self.controls.half_m = self._ground.half_m
        if state.real != self._real:
            self._real = state.real
            self.controls.size = _TRUE_SIZE if state.real else _SIMULATED_SIZE
        lost, size = self._lost(now), self.controls.size
        self._robots.show(robots, poses, lost, flashes, size, state.models)
        if self._clear or state.begun != self._begun:
            self._clear, self._begun = False, state.begun
            self._trails.clear()
        self._trails.length_s = self.controls.trail_s
        self.remember(now)
        self._trail_scene.show(self._trails, self.controls.size)
        self._links.show(state.both, state.one_way, robots, poses, flashes)
        self._markers.show(state.markers, by_robot, now)
        self.controls.move_cameras(by_robot)
        if now >= self._next_panel:
            self._next_panel = now + _PANEL_PERIOD_S
            self._show_panel(now)

    def _reach(self, poses: Floats) -> None:
        distance = float(np.abs(poses[:2]).max(initial=0.0))
        if self._state.real:
            self._ground.reach(max(distance, self._state.markers.reach()), LAB_HALF_M)
        else:
            self._ground.reach(distance, HALF_M)

    def _lost(self, now: float) -> NDArray[np.bool_]:
        """Return which robots are silent that should not be."""
        return self._state.fleet.lost(now) & (not self._state.ended)

    def _show_panel(self, now: float) -> None:
        state = self._state
        fleet, paused = state.fleet, state.states.paused(now)
        columns = zip(fleet.robots, fleet.newest().T, fleet.speeds(), self._lost(now), strict=True)
        rows = [
            RobotRow(
                robot,
                float(speed),
                (float(pose[0]), float(pose[1]), float(pose[2])),
                *self._describe(robot, bool(lost), float(speed), now),
                bool(lost),
            )
            for robot, pose, speed, lost in columns
        ]
        run = 'paused' if paused else state.clock.describe(now)
        run = 'EMERGENCY STOP' if state.states.stopped else run
        if state.ended:
            run = 'run ended'
        elif unseen := sorted(set(state.announced) - set(fleet.robots)):
            run += f'; {robots_in_words(unseen, "are")} announced, but not seen'
        self.controls.title = self._title(now)
        text = panel_html(rows, run, state.clock.seconds(now), fleet.disagreement(self._lost(now)))
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
