"""Robots: bodies in their colours, numbers above them, and rings that flash."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import viser
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import fleet
from setcmas_simu.robots.model import Shape
from setcmas_simu.robots.models import UNICYCLE, shape_of
from setcmas_tools.view.scene.batch import Batch
from setcmas_tools.view.scene.robot_mesh import coloured_body, dark_body, unit_ring

_DARK = np.array([0.16, 0.18, 0.21])
_PALE = np.array([0.9, 0.91, 0.93])
_PALENESS = 0.75
_FLASH_FROM_M, _FLASH_TO_M = 0.15, 0.45  # radius of the ring, of a robot in its true size


class _Bodies:
    """The robots of one model."""

    def __init__(self, scene: viser.SceneApi, root: str, model: str, shape: Shape) -> None:
        self.shape = shape
        name = f'{root}/robots/{model.replace("/", "_")}'
        self._coloured = Batch(scene, f'{name}/coloured', coloured_body(shape))
        self._dark = Batch(scene, f'{name}/dark', dark_body(shape))

    def show(
        self, positions: Floats, wxyzs: Floats, scales: Floats, colours: Floats, dark: Floats
    ) -> None:
        """Draw these robots in place of the last ones of the model."""
        self._coloured.show(positions, wxyzs, scales, colours)
        self._dark.show(positions, wxyzs, scales, dark)


class RobotScene:
    """Draws a fleet; what has not changed costs nothing.

    Attributes:
        ghosts: Whether the robots are pale and have no numbers.
    """

    def __init__(self, scene: viser.SceneApi, root: str = '') -> None:
        """Prepare, in a frame; nothing is drawn yet."""
        self._scene, self._root = scene, root
        self.ghosts = False
        self._bodies: dict[str, _Bodies] = {}
        self._rings = Batch(scene, f'{root}/robots/rings', unit_ring(), side='double')
        self._labels: dict[int, viser.LabelHandle] = {}

    def show(
        self,
        robots: list[int],
        poses: Floats,
        lost: NDArray[np.bool_],
        flashes: Floats,
        size: float,
        models: Mapping[int, str],
    ) -> None:
        """Draw the fleet.

        Args:
            robots: Numbers, N of them.
            poses: Rows x, y in m and theta in rad, shape (3, N).
            lost: Which ones are to be faded, shape (N,).
            flashes: How bright each one's ring is, from 0 to 1, shape (N,).
            size: How many times larger than in reality.
            models: Names of the robots' models; those that are not there are unicycles.
        """
        n = len(robots)
        positions = np.column_stack([poses[0], poses[1], np.zeros(n)])
        half = 0.5 * poses[2]
        zero = np.zeros(n)
        wxyzs = np.column_stack([np.cos(half), zero, zero, np.sin(half)])
        scales = np.full((n, 3), size)
        colours = np.array([fleet.plot_colour(robot) for robot in robots]).reshape(-1, 3)
        faded = np.where(lost | self.ghosts, _PALENESS, 0.0)[:, None]
        bright = colours + faded * (_PALE - colours)
        dark = _DARK + faded * (_PALE - _DARK)
        names = np.array([models.get(robot, UNICYCLE) for robot in robots], dtype=object)
        for name in {*self._bodies, *names}:
            own = names == name
            self._bodies_of(name).show(
                positions[own], wxyzs[own], scales[own], bright[own], dark[own]
            )
        radii = _FLASH_FROM_M + (1.0 - flashes) * (_FLASH_TO_M - _FLASH_FROM_M)
        radii = size * np.where(flashes > 0, radii, 0.0)
        rings = np.column_stack([radii, radii, np.ones(n)])
        self._rings.show(np.where(radii[:, None] > 0, positions, 0.0), wxyzs, rings, colours)
        heights = [size * self._bodies[name].shape.height + 0.08 for name in names]
        self._show_labels(robots, positions, lost, heights)

    def _bodies_of(self, model: str) -> _Bodies:
        if model not in self._bodies:
            self._bodies[model] = _Bodies(self._scene, self._root, model, shape_of(model))
        return self._bodies[model]

    def _show_labels(
        self,
        robots: list[int],
        positions: Floats,
        lost: NDArray[np.bool_],
        heights: list[float],
    ) -> None:
        for robot in self._labels.keys() - set(robots):
            self._labels.pop(robot).remove()
        for robot, place, is_lost, height in zip(
            robots, positions.tolist(), lost, heights, strict=True
        ):
            text = f'{robot} lost' if is_lost else str(robot)
            position = (place[0], place[1], height)
            if robot not in self._labels:
                self._labels[robot] = self._scene.add_label(
                    f'{self._root}/numbers/{robot}',
                    text,
                    position=position,
                    anchor='bottom-center',
                )
            label = self._labels[robot]
            label.text = text
            label.visible = not self.ghosts
            label.position = position
