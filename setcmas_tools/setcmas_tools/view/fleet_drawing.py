"""A fleet in a 3D scene, drawn anew at every frame."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np
import viser
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.view.model.fleet_state import NO_PAIRS, FleetState
from setcmas_tools.view.model.trails import LENGTH_S, Trails
from setcmas_tools.view.scene.ground_scene import HALF_M, LAB_HALF_M, GroundScene
from setcmas_tools.view.scene.link_scene import LinkScene
from setcmas_tools.view.scene.marker_scene import MarkerScene
from setcmas_tools.view.scene.robot_scene import RobotScene
from setcmas_tools.view.scene.trail_scene import TrailScene

Placed = tuple[float, list[int], Floats, Collection[int]]
"""Time in s, robots, their positions in m, shape (2, N), and those that did not drive there."""


class FleetDrawing:
    """Draws what is known of a fleet: ground, robots, trails, links, markers.

    Attributes:
        ground: The ground below it.
        robots: The robots.
        trails: The trails behind them.
        trail_s: Length of the trails in s.
    """

    def __init__(
        self, scene: viser.SceneApi, state: FleetState, root: str = '', floor: str = ''
    ) -> None:
        """Prepare.

        Args:
            scene: Where to draw.
            state: What is known.
            root: Name of the frame that all is in; empty is the world.
            floor: Name of the frame that the ground is in.
        """
        self._state = state
        self.ground = GroundScene(scene, floor or root)
        self.trail_s = LENGTH_S
        self.robots = RobotScene(scene, root)
        self._trails, self.trails = Trails(), TrailScene(scene, root)
        self._links = LinkScene(scene, root)
        self._markers = MarkerScene(scene, root)
        self._begun = 0
        self._clear = False

    def clear_trails(self) -> None:
        """Forget the trails: robots have been put somewhere else."""
        self._clear = True  # by the thread that draws

    def retrace(self, past: Iterable[Placed]) -> None:
        """Draw other trails: those of the time before another one than was expected."""
        self._trails.clear()
        for t, robots, xy, put in past:
            self._trails.extend(t, robots, xy, put)

    def remember(self, now: float) -> None:
        """Let trails grow, whether somebody looks or not."""
        fleet = self._state.fleet
        self._trails.extend(now, fleet.robots, fleet.poses(now)[:2], fleet.take_put())

    def update(self, now: float, size: float) -> dict[int, tuple[float, float, float]]:
        """Draw the picture of a time.

        Args:
            now: The time in s.
            size: How many times larger than in reality robots are.

        Returns:
            Where robots are drawn: x, y in m and theta in rad, by their numbers.
        """
        state = self._state
        robots, poses = state.fleet.robots, state.fleet.poses(now)
        flashes = state.flashes.strength(robots, now) * (not self.robots.ghosts)
        links = (NO_PAIRS, NO_PAIRS) if self.robots.ghosts else (state.both, state.one_way)
        by_robot = dict(zip(robots, map(tuple, poses.T.tolist()), strict=True))
        self._reach(poses)
        self.robots.show(robots, poses, self.lost(now), flashes, size, state.models)
        if self._clear or state.begun != self._begun:
            self._clear, self._begun = False, state.begun
            self._trails.clear()
        self._trails.length_s = self.trail_s
        self.remember(now)
        self.trails.show(self._trails, size)
        self._links.show(*links, robots, poses, flashes)
        self._markers.show(state.markers, by_robot)
        return by_robot

    def lost(self, now: float) -> NDArray[np.bool_]:
        """Return which robots are silent that should not be."""
        return self._state.fleet.lost(now) & (not self._state.ended)

    def _reach(self, poses: Floats) -> None:
        distance = float(np.abs(poses[:2]).max(initial=0.0))
        if self._state.real:
            self.ground.reach(max(distance, self._state.markers.reach()), LAB_HALF_M)
        else:
            self.ground.reach(distance, HALF_M)
