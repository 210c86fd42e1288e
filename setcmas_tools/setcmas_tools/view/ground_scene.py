"""The ground: a grid with a line per metre, axes, and the metres written along them."""

from __future__ import annotations

import numpy as np
import viser

_STEP_M = 5.0
LEAST_HALF_M = 7.5
"""Half the side of the ground at first, in m."""
_MARGIN_M = 2.5
_CLEAR_M = 0.5
_FLOOR = (246, 248, 250)
_CELL = (238, 240, 244)
_SECTION = (222, 227, 233)
_AXES = {'x': (200, 40, 40), 'y': (30, 140, 60)}


class GroundScene:
    """A square of ground around the origin that grows with the way of the robots."""

    def __init__(self, scene: viser.SceneApi) -> None:
        """Draw it as large as the default start poses ask for."""
        self._scene = scene
        self.half_m = 0.0
        self._ticks: list[viser.LabelHandle] = []
        for axis, colour in _AXES.items():
            end = np.array([1.0 if name == axis else 0.0 for name in 'xyz'])
            points = np.stack([np.zeros(3), end])[None] + [0.0, 0.0, 0.006]
            scene.add_arrows(
                f'/axes/{axis}',
                points,
                colour,
                shaft_radius=0.02,
                head_radius=0.06,
                head_length=0.18,
            )
            scene.add_label(
                f'/axes/{axis}_name',
                axis,
                position=tuple(1.18 * end),
                anchor='center-center',
                font_screen_scale=0.8,
            )
        self.reach(0.0)

    def reach(self, distance_m: float) -> None:
        """Let the ground be seen as far as robots are from the origin along x or y."""
        if distance_m + _CLEAR_M <= self.half_m:
            return
        steps = np.ceil((distance_m + _CLEAR_M - _MARGIN_M) / _STEP_M)
        self.half_m = max(LEAST_HALF_M, float(_STEP_M * steps + _MARGIN_M))
        side = 2 * self.half_m
        self._scene.add_grid(
            '/ground', side, side, cell_size=1.0, section_size=_STEP_M, cell_color=_CELL,
            section_color=_SECTION, cell_thickness=1.0, section_thickness=1.0,
            plane_color=_FLOOR, plane_opacity=1.0, shadow_opacity=0.0, fade_strength=0.0,
            fade_distance=1000.0,
        )  # fmt: skip
        self._write_metres()

    def _write_metres(self) -> None:
        for tick in self._ticks:
            tick.remove()
        last = int(self.half_m // _STEP_M)
        edge = self.half_m + 0.45
        self._ticks = []
        for step in range(-last, last + 1):
            metres = step * _STEP_M
            for axis, place in (('x', (metres, -edge, 0.0)), ('y', (-edge, metres, 0.0))):
                name = f'/metres/{axis}{step + last}'
                text = f'{metres:g} m'.replace('-', '−')
                self._ticks.append(
                    self._scene.add_label(
                        name, text, position=place, anchor='center-center', font_screen_scale=0.7
                    )
                )
