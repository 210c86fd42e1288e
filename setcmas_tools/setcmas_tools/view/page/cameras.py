"""Camera of a browser: the whole fleet from the side or from above, or one robot."""

from __future__ import annotations

import numpy as np
import viser

from setcmas_tools.view.model.camera_places import FOV, SIDE, place

FREE = 'no robot'

_NEAR_M = np.array([-2.6, -1.8, 2.0])  # from the robot to the camera that follows it
_NEAREST_M = 0.1  # a nearer plane leaves too few bits of depth to tell a line from its ground
_PANEL_PX = 340
_MOVED_M = 0.05
_SMALL_PX = 2 * _PANEL_PX  # in narrower windows, and on phones, the panel is folded


class FollowingCamera:
    """The camera of one browser, which may follow a robot."""

    def __init__(
        self, client: viser.ClientHandle, order: float, half_m: float, covered_px: int = 0
    ) -> None:
        """Show the whole ground at first.

        Args:
            client: The browser.
            order: Place of the choice of the robot in its panel.
            half_m: Half the side of the ground in m.
            covered_px: Height of the panel below the scene.
        """
        self._client = client
        self._covered_px = covered_px
        self._robot: int | None = None
        self._options: tuple[str, ...] = (FREE,)
        self._dropdown = client.gui.add_dropdown('Follow', self._options, order=order)
        self._dropdown.on_update(lambda _: self._choose(str(self._dropdown.value)))
        client.camera.near = _NEAREST_M
        self._beside_m = 0.0
        self.show(SIDE, half_m)

    def offer(self, robots: list[int]) -> None:
        """Offer these robots to be followed."""
        options = (FREE, *[f'robot {robot}' for robot in robots])
        if options != self._options:
            self._options = options
            self._dropdown.options = options

    def show(self, name: str, half_m: float) -> None:
        """Show one of the `VIEWS`, and follow no robot any more."""
        self._robot = None
        self._dropdown.value = FREE  # type: ignore[misc]  # it has a setter
        camera = self._client.camera
        self._view, self._fitted = name, self._fitting(half_m)
        width = camera.image_width
        folded = camera.aspect < 1.0 or width <= _SMALL_PX
        covered = 0.0 if folded else _PANEL_PX / width
        below = 0.0 if folded else min(0.45, self._covered_px / camera.image_height)
        position, target = place(name, half_m, camera.aspect, covered, below, self._beside_m)
        with self._client.atomic():
            camera.up_direction = (0.0, 0.0, 1.0)
            camera.fov = FOV
            camera.position = position
            camera.look_at = target
        self._place = position

    def fit(self, half_m: float, beside_m: float = 0.0) -> None:
        """Go on showing the whole ground when it grows, or the window changes its size.

        A camera that the user has moved, or that follows a robot, is left alone.

        Args:
            half_m: Half the side of the ground in m.
            beside_m: How far to the right in m there is a second one; 0 for none.
        """
        self._beside_m = beside_m
        camera = self._client.camera
        moved = self._robot is not None or not np.allclose(
            camera.position, self._place, atol=_MOVED_M
        )
        if self._fitting(half_m) != self._fitted and not moved:
            self.show(self._view, half_m)

    def update(self, poses: dict[int, tuple[float, float, float]]) -> None:
        """Look at the robot that is followed, from the side that the user has turned to."""
        if self._robot is None or self._robot not in poses:
            return
        x, y, _ = poses[self._robot]
        camera = self._client.camera
        target = np.array([x, y, 0.2])
        offset = camera.position - camera.look_at
        with self._client.atomic():
            camera.position = target + offset
            camera.look_at = target

    def _fitting(self, half_m: float) -> tuple[float, float, int, int]:
        """Return what the place of the camera depends on."""
        camera = self._client.camera
        return half_m, self._beside_m, camera.image_width, camera.image_height

    def _choose(self, option: str) -> None:
        self._robot = None if option == FREE else int(option.split()[-1])
        if self._robot is None:
            return
        camera = self._client.camera
        with self._client.atomic():  # near the robot at first; the user may turn and zoom then
            target = camera.look_at
            camera.position = target + _NEAR_M
            camera.look_at = target
