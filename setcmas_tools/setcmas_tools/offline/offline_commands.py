"""Control laws of a simulated fleet, and the commands of its robots from their velocities."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import GainOptions, LawOptions
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_ctrl.laws.script_search import LawScripts
from setcmas_ctrl.saturation import saturate
from setcmas_ctrl.si_to_uni import Conversion, VelocityConversion
from setcmas_simu.arrays import Floats, single_precision
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import check_in_fleet, format_per_robot, format_robots
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.script_calls import Function
from setcmas_tools.offline import run_progress


class FleetLaws:
    """The control laws of a fleet.

    Attributes:
        laws: The law of each robot, from robot 1 on.
        reports: Failures of their calls.
    """

    def __init__(
        self, chosen: LawOptions, nb_robots: int, warn: Callable[[str], None] = print
    ) -> None:
        """Load the laws; `warn` shows messages about failing ones.

        Raises:
            SetcmasError: A script does not load, or a robot has no law.
        """
        self.reports = ErrorReports(warn)
        self._call = run_progress.current.call
        algo = chosen.algo
        robots = range(1, nb_robots + 1)
        by_robot = algo if isinstance(algo, Mapping) else dict.fromkeys(robots, algo)
        functions = {robot: law for robot, law in by_robot.items() if callable(law)}
        named = {robot: str(law) for robot, law in by_robot.items() if robot not in functions}
        scripts = None
        if named:
            text = format_per_robot(named) if isinstance(algo, Mapping) else str(algo)
            scripts = LawScripts(text, chosen.exercise, chosen.set)
            scripts.check(nb_robots, functions)
        check_in_fleet(functions, nb_robots, 'algo')
        if missing := [robot for robot in robots if robot not in by_robot]:
            raise SetcmasError(
                f'algo has no control law for robot{"s" * (len(missing) > 1)} '
                f'{format_robots(missing)}; add it to the dictionary'
            )
        self.laws: list[ControlLaw] = []
        for robot in robots:
            if robot in functions or scripts is None:
                self.laws.append(ControlLaw(functions[robot], robot, nb_robots))
                continue
            script = scripts.script(robot)
            self._call.begin(robot, script, Function.LOADING)
            self.laws.append(ControlLaw(script, robot, nb_robots, scripts.settings[script]))
            self._call.end()

    def __call__(
        self, known_poses: Iterable[Floats], t: float, adjacency: Floats | None
    ) -> Floats:
        """Return the velocities that the laws want at time t (s): rows vx, vy in m/s, (2, N).

        They are zero where a law fails.

        Args:
            known_poses: The poses that each law gets, of shape (3, N).
            t: Time in s.
            adjacency: Weights of the graph, shape (N, N); None is the complete one.
        """
        wanted: list[float] = []
        for law, poses in zip(self.laws, known_poses, strict=False):  # poses may be endless
            self._call.begin(law.robot, law.path)
            try:
                wanted += law(poses, t, adjacency)
                self.reports.succeeded(law.robot, t)
            except ControlError as error:
                wanted += (0.0, 0.0)
                self.reports.failed(law.robot, t, error)
        self._call.end()
        velocities: Floats = np.fromiter(wanted, float).reshape(-1, 2).T
        return velocities


class Commanded(NamedTuple):
    """Commands of N robots.

    Attributes:
        wanted: Velocities of the laws after saturation: rows vx, vy in m/s, shape (2, N).
        commands: Speeds forward and to the left (m/s) and turn rates (rad/s), shape (3, N).
        allowed: Velocities after the safety filter: rows vx, vy and a `Verdict`, shape (3, N);
            None without a filter.
    """

    wanted: Floats
    commands: Floats
    allowed: Floats | None = None


class Commander:
    """Saturation, safety filter and conversion in a row, for a fleet of N robots."""

    def __init__(
        self,
        gains: GainOptions,
        options: FilterOptions,
        nb_robots: int,
        report: Callable[[str], None] = print,
        scripts: Sequence[Conversion] = (),
    ) -> None:
        """Prepare to command N robots; `use` sets their models.

        `report` is called with a message when the filter stops robots for long; `scripts` are the
        conversions of the N robots, instead of the built-in one.

        Raises:
            SetcmasError: The filter cannot guarantee safety at this rate.
        """
        self._vnom = gains.vnom
        self._convert = VelocityConversion(
            nb_robots,
            gains.komega,
            1.0 / gains.rate,
            options.accel or math.inf,
            options.lookahead,
            scripts,
        )
        self._filter = None
        if options.is_on:  # loads the solver only if needed
            from setcmas_ctrl.filter.safety_filter import SafetyFilter

            self._filter = SafetyFilter(options, nb_robots, self._convert, report)

    def use(self, models: Sequence[RobotModel]) -> None:
        """Set the models of the N robots, or raise SetcmasError."""
        (self._filter or self._convert).use(models)

    def __call__(self, velocities: Floats, poses: Floats) -> Commanded:
        """Return the commands for one period.

        Args:
            velocities: Velocities of the laws: rows vx, vy in m/s, shape (2, N).
            poses: Poses of the fleet: rows x, y in m and theta in rad, shape (3, N).
        """
        convert = self._convert
        wanted = single_precision(saturate(velocities, self._vnom))
        if not self._filter:
            return Commanded(wanted, convert(wanted, poses))
        allowed = self._filter(wanted, poses, self._vnom)
        return Commanded(wanted, convert.last, np.vstack(allowed))
