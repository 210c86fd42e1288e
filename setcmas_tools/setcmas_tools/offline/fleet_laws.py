"""The control laws of a whole fleet, called one after the other without ROS."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import repeat

import numpy as np

from setcmas_ctrl.communication.graph import complete
from setcmas_ctrl.control.commander import Commanded, Commander
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.control_options import Algo, LawOptions
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.scripts.script_errors import ControlError, ErrorReports
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.per_robot import check_in_fleet, format_per_robot
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.offline import run_progress


def load_laws(chosen: LawOptions, nb_robots: int) -> list[ControlLaw]:
    """Return the control laws of robots 1 to nb_robots, or raise SetcmasError."""
    algo = chosen.algo
    robots = range(1, nb_robots + 1)
    by_robot = algo if isinstance(algo, Mapping) else dict.fromkeys(robots, algo)
    functions = {robot: law for robot, law in by_robot.items() if callable(law)}
    scripts = None
    if len(functions) < len(by_robot):
        scripts = LawScripts(_text(algo, functions), chosen.exercise, chosen.set)
        scripts.check(nb_robots, functions)
    check_in_fleet(functions, nb_robots, 'algo')
    notes = run_progress.current
    laws = []
    for robot in robots:
        if robot in functions or scripts is None:
            laws.append(ControlLaw.of_function(functions[robot], robot, nb_robots))
            continue
        notes.enter(Function.LOADING, scripts.script(robot))
        notes.begin(robot)
        laws.append(scripts.law(robot, nb_robots))
        notes.end()
    return laws


def _text(algo: Algo, functions: Collection[int]) -> str:
    if not isinstance(algo, Mapping):
        return str(algo)
    scripts = {robot: str(law) for robot, law in algo.items() if robot not in functions}
    return format_per_robot(scripts)


class FleetLaws:
    """The control laws of a fleet, from poses to commands."""

    def __init__(
        self, laws: Sequence[ControlLaw], commander: Commander, warn: Callable[[str], None]
    ) -> None:
        """Prepare the laws of robots 1 to N; `warn` shows messages about failing ones."""
        self._laws = laws
        self._commander = commander
        self.reports = ErrorReports(warn)
        self._complete = complete(len(laws))
        self._progress = run_progress.current

    def __call__(
        self,
        poses: Floats,
        t: float,
        received: Iterable[Floats] | None = None,
        adjacency: Floats | None = None,
    ) -> Commanded:
        """Return the wanted velocities and the commands, for poses (3, N) at time t (s).

        `received` are the poses for each law instead; the default graph is the complete one.
        """
        wanted: list[float] = []
        notes = self._progress
        adjacency = self._complete if adjacency is None else adjacency
        known_poses = repeat(poses) if received is None else received
        for law, known in zip(self._laws, known_poses, strict=False):
            notes.enter(Function.CONTROL, law.path)
            notes.begin(law.robot)
            try:
                wanted += law(known, t, adjacency)
                self.reports.succeeded(law.robot, t)
            except ControlError as error:
                wanted += (0.0, 0.0)
                self.reports.failed(law.robot, t, error)
        notes.end()
        return self._commander(np.fromiter(wanted, float).reshape(-1, 2).T, poses)
