"""Controls beside the scene: figures of the fleet, buttons for robots, choices of the view."""

from __future__ import annotations

import threading

import viser

from setcmas_tools.view.model.camera_places import VIEWS
from setcmas_tools.view.model.trails import LENGTH_S, LONGEST_S
from setcmas_tools.view.page.buttons import Actions, Buttons
from setcmas_tools.view.page.cameras import FollowingCamera
from setcmas_tools.view.page.screenshot import take_screenshot
from setcmas_tools.view.scene.ground_scene import HALF_M

_FIGURES, _BUTTONS, _VIEW, _FOLLOW, _TRAILS, _SIZE, _SCREENSHOT = range(7)


class Controls:
    """The panel.

    Attributes:
        trail_s: Length of the trails in s that the users have chosen.
        size: How many times larger than in reality robots are drawn.
        half_m: Half the side of the ground in m, which cameras show.
        beside_m: How far to the right in m there is a second ground; 0 for none.
        covered_px: Height of the panel below the scene, if there is one.
        buttons: Those that command the robots; None for a view that can only be looked at.
        title: What a picture is of.
    """

    def __init__(self, server: viser.ViserServer, actions: Actions | None, size: float) -> None:
        """Build the panel.

        Args:
            server: Of the page.
            actions: None for a view that can only be looked at.
            size: Of the robots, at first.
        """
        self._server = server
        self.half_m = HALF_M
        self.covered_px, self.beside_m = 0, 0.0
        self.title = ''
        self._cameras: dict[int, FollowingCamera] = {}
        self._lock = threading.Lock()  # browsers come and go in viser's threads
        gui = server.gui
        self._figures = gui.add_html('', order=_FIGURES)
        self.buttons = Buttons(gui, actions, _BUTTONS) if actions else None
        views = gui.add_button_group('Camera', VIEWS, order=_VIEW)
        views.on_click(lambda event: self._look(event.client, str(views.value)))
        self._trail = gui.add_slider(
            'Trails (s)', min=0, max=LONGEST_S, step=5, initial_value=LENGTH_S, order=_TRAILS
        )
        self._size = gui.add_slider(
            'Robot size', min=1, max=6, step=0.5, initial_value=size, order=_SIZE,
            hint='1 is the true size of a TurtleBot3',
        )  # fmt: skip
        screenshot = gui.add_button('Screenshot', icon=viser.Icon.CAMERA, order=_SCREENSHOT)
        screenshot.on_click(lambda event: take_screenshot(event.client, self.title))
        server.on_client_connect(self._on_connect)
        server.on_client_disconnect(self._on_disconnect)

    @property
    def trail_s(self) -> float:
        """Length of the trails in s."""
        return float(self._trail.value)

    @property
    def size(self) -> float:
        """How many times larger than in reality robots are drawn."""
        return float(self._size.value)

    @size.setter
    def size(self, size: float) -> None:
        self._size.value = size  # type: ignore[misc]  # it has a setter

    def show_figures(self, text: str) -> None:
        """Show the panel's text (HTML)."""
        self._figures.content = text

    def offer(self, robots: list[int]) -> None:
        """Let every browser follow one of these robots."""
        for camera in self._followers():
            camera.offer(robots)

    def move_cameras(self, poses: dict[int, tuple[float, float, float]]) -> None:
        """Let the cameras go along with the robots that they follow."""
        for camera in self._followers():
            camera.fit(self.half_m, self.beside_m)
            camera.update(poses)

    def _followers(self) -> list[FollowingCamera]:
        with self._lock:
            return list(self._cameras.values())

    def _on_connect(self, client: viser.ClientHandle) -> None:
        camera = FollowingCamera(client, _FOLLOW, self.half_m, self.covered_px)
        with self._lock:
            self._cameras[client.client_id] = camera

    def _on_disconnect(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._cameras.pop(client.client_id, None)

    def _look(self, client: viser.ClientHandle | None, name: str) -> None:
        camera = self._cameras.get(client.client_id) if client else None
        if camera:
            camera.show(name, self.half_m)
