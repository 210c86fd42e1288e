"""The control laws of a whole fleet, called one after the other without ROS."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.options import GainOptions
from setcmas_ctrl.control.saturation import saturate
from setcmas_ctrl.scripts.error_reports import ErrorReports
from setcmas_ctrl.scripts.failures import ControlError
from setcmas_ctrl.scripts.loader import find_script
from setcmas_ctrl.scripts.settings import Settings
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import RobotModel

Floats = NDArray[np.float64]


def load_laws(
    algo: str | Path | Callable[..., Any], nb_robots: int, settings: Settings | None = None
) -> list[ControlLaw]:
    """Return the control laws of robots 1 to nb_robots.

    Raises:
        SetcmasError: The script cannot be found or loaded, or a function is to take settings.
    """
    if callable(algo):
        if settings:
            raise SetcmasError('settings are for scripts; a function takes none')
        return [ControlLaw.of_function(algo, i + 1, nb_robots) for i in range(nb_robots)]
    path = find_script(str(algo))
    return [ControlLaw(path, robot + 1, nb_robots, settings) for robot in range(nb_robots)]


class FleetLaws:
    """The control laws of a fleet, from the poses to the robots' commands."""

    def __init__(
        self,
        laws: Sequence[ControlLaw],
        robots: RobotModel,
        gains: GainOptions,
        warn: Callable[[str], None],
    ) -> None:
        """Prepare.

        Args:
            laws: The laws of robots 1 to N.
            robots: How these robots move.
            gains: How fast they follow the laws.
            warn: Shows messages about failing laws.
        """
        self._laws = laws
        self._robots = robots
        self._gains = gains
        self._reports = ErrorReports(warn)
        self._failing = False
        self.call_time: Floats = np.zeros(len(laws))

    @property
    def failed_robots(self) -> list[int]:
        """The robots whose law has failed at some time, sorted."""
        return self._reports.failed_robots

    def __call__(
        self,
        poses: Floats,
        t: float,
        heard: Iterable[Floats] | None = None,
        adjacency: Floats | None = None,
    ) -> tuple[Floats, Floats]:
        """Return the saturated velocities (2, N), and the commands (3, N) for them.

        Args:
            poses: Rows x, y in m and theta in rad, shape (3, N).
            t: Time in s.
            heard: The poses that each law is given instead, shapes (3, N).
            adjacency: Who hears whom, shape (N, N); None is complete.
        """
        wanted = []
        durations = []
        clock = time.perf_counter
        for law, known in zip(self._laws, repeat(poses) if heard is None else heard, strict=False):
            begin = clock()
            try:
                velocity = law(known, t, adjacency)
                if self._failing:
                    self._reports.succeeded(law.robot, t)
            except ControlError as error:
                velocity = (0.0, 0.0)
                self._failing = True
                self._reports.failed(law.robot, t, error)
            wanted.append(velocity)
            durations.append(clock() - begin)
        self.call_time += durations
        velocities = saturate(np.array(wanted).T, self._gains.vnom)
        return velocities, self._robots.command(velocities, poses, self._gains.komega)
