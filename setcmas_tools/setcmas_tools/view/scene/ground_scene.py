"""Ground: a grid with lines at least every metre, axes, and the metres along its border."""

from __future__ import annotations

import numpy as np
import viser

HALF_M = 7.5
"""Half the side of the ground in a simulation at first, in m."""
LAB_HALF_M = 2.5
"""Half the side of the ground in an experiment at first, in m."""

_BELOW_M = 0.01  # so that what lies on the ground does not flicker through it
_METRES_AT = 1.06
_CLEAR_M = 0.5
_FARTHEST_M = 100.0  # farther robots leave the ground: its metres could not be read, nor drawn
_STEPS_M = {False: 1.0, True: 5.0}  # from one written line to the next: small, large ground
_LARGE_M = 7.0
_FLOOR = (246, 248, 250)
_CELL = (238, 240, 244)
_SECTION = (222, 227, 233)
_AXES = {'x': (200, 40, 40), 'y': (30, 140, 60)}


class GroundScene:
    """A square of ground around the origin that grows with the way of the robots.

    Attributes:
        half_m: Half its side in m.
    """

    def __init__(self, scene: viser.SceneApi, root: str = '') -> None:
        """Draw it, in a frame, as large as the default start poses ask for."""
        self._scene, self._root = scene, root
        self.half_m = self._least_m = 0.0
        self._ticks: list[viser.LabelHandle] = []
        for axis, colour in _AXES.items():
            end = np.array([1.0 if name == axis else 0.0 for name in 'xyz'])
            points = np.stack([np.zeros(3), end])[None] + [0.0, 0.0, 0.006]
            scene.add_arrows(
                f'{root}/axes/{axis}',
                points,
                colour,
                shaft_radius=0.013,
                head_radius=0.045,
                head_length=0.18,
            )
            scene.add_label(
                f'{root}/axes/{axis}_name',
                axis,
                position=tuple(1.18 * end),
                anchor='center-center',
                font_screen_scale=0.8,
            )
        self.reach(0.0, HALF_M)

    def reach(self, distance_m: float, least_m: float) -> None:
        """Let the ground be seen as far as robots are from the origin along x or y.

        Args:
            distance_m: How far, in m.
            least_m: Half the least side in m; another one than before lets the ground shrink.
        """
        distance_m = min(distance_m, _FARTHEST_M)
        fits = distance_m + _CLEAR_M <= self.half_m and least_m == self._least_m
        if fits:
            return
        self._least_m = least_m
        step = _STEPS_M[least_m >= _LARGE_M or distance_m >= _LARGE_M]
        steps = np.ceil((distance_m + _CLEAR_M - 0.5 * step) / step)
        self.half_m = max(least_m, float(step * (steps + 0.5)))
        self._draw(step)

    def _draw(self, step: float) -> None:
        side = 2 * self.half_m
        self._scene.add_grid(
            f'{self._root}/ground', side, side, cell_size=min(1.0, step / 2), section_size=step,
            cell_color=_CELL, section_color=_SECTION, cell_thickness=1.0, section_thickness=1.0,
            plane_color=_FLOOR, plane_opacity=1.0, shadow_opacity=0.0, fade_strength=0.0,
            fade_distance=1000.0, position=(0.0, 0.0, -_BELOW_M),
        )  # fmt: skip
        self._write_metres(step)

    def _write_metres(self, step: float) -> None:
        for tick in self._ticks:
            tick.remove()
        last = int(self.half_m // step)
        edge = _METRES_AT * self.half_m
        self._ticks = []
        for number in range(-last, last + 1):
            metres = number * step
            for axis, place in (('x', (metres, -edge, 0.0)), ('y', (-edge, metres, 0.0))):
                name = f'{self._root}/metres/{axis}{number + last}'
                text = f'{metres:g} m'.replace('-', '−')
                self._ticks.append(
                    self._scene.add_label(
                        name, text, position=place, anchor='center-center', font_screen_scale=0.7
                    )
                )
