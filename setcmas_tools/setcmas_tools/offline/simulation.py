"""One simulated run: what `simulate` was given, what it needs on the way, and what it leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import chosen_communication
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.control_options import GainOptions
from setcmas_ctrl.control.references import References, references_of_fleet
from setcmas_ctrl.filter.clearance import check_starts
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.scripts.script_errors import ErrorReports
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import ClashError
from setcmas_simu.robots.arena import ObstaclesKind
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.models import absolute, check_models, model_names, robot_models
from setcmas_simu.simulator.simulator_options import SimulationOptions
from setcmas_tools.offline.fleet_laws import load_laws
from setcmas_tools.offline.given import (
    condition_name,
    failures,
    given_files,
    given_scripts,
    graph_entry,
    name_of,
    pose_options,
    script_entry,
)
from setcmas_tools.run.inputs import model_inputs
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import RunOptions
from setcmas_tools.run.run_info import Outcome, RunInfo
from setcmas_tools.run.run_tables import RunTables

MAX_STATES = 10_000_000
"""The most states of robots in a run, a state a robot and step; they are held in memory."""

_BYTES_A_STATE = 500  # measured: 150 to 220, and once more while the run changes processes


class Simulation:
    """A run to be simulated: the arguments of `simulate`, and what follows from them.

    Attributes:
        nb_robots: Size of the fleet.
        rate: That of control in Hz.
        robot_rate: That of the robots' steps in Hz.
        seed: That of all random numbers.
        warn: Shows messages.
        progress: Is told how far the run is; may be None.
        start: Start poses, shape (3, nb_robots).
        nb_steps: How many steps the robots make.
        gains: Those of the laws.
        safety: What keeps robots apart.
        tells: How the robots communicate.
        models: How each robot moves; there are none before `load`, nor laws.
        laws: That of each robot.
    """

    models: list[RobotModel]
    laws: list[ControlLaw]
    _references: References | None

    def __init__(self, **given: Any) -> None:
        """Check the arguments of `simulate`, before a script is loaded.

        Raises:
            SetcmasError: One makes no sense.
        """
        self._given = given
        self.nb_robots: int = given['nb_robots']
        self.rate: float = given['rate']
        self.robot_rate: float = given['robot_rate']
        self.seed: int = given['seed']
        self.warn: Callable[[str], None] = given['warn']
        self.progress: Callable[[float], object] | None = given['progress']
        RunOptions(duration=given['duration'])
        self._simulation = SimulationOptions.among({**given, 'poses': None})
        self.gains = GainOptions.among(given)
        obstacles = given['obstacles'] and ObstaclesKind().parse(given['obstacles'])
        self.safety = FilterOptions.among({**given, 'obstacles': obstacles})
        self.nb_steps = self._simulation.nb_steps(given['duration'])
        _check_size(self.nb_steps, self.nb_robots)
        self.start = _start(self._simulation, self.nb_robots, given['poses'])
        check_starts(self.safety, self.start)
        self._options = CommunicationOptions.among(given)
        self.tells = chosen_communication(self.nb_robots, self._options, self.seed)
        names = model_names(given['model'], self.nb_robots)
        check_models(names, given['limits'])
        # Files are found before a script is loaded: it may change the current folder.
        self._names = absolute(names)
        self._inputs = [
            *model_inputs(given['model'], self.nb_robots),
            *given_files(self.tells.condition_script, given['graph']),
        ]

    def load(self) -> None:
        """Load the scripts of laws and robots.

        Raises:
            SetcmasError: One cannot be loaded.
        """
        robots = range(1, self.nb_robots + 1)
        self.models = robot_models(self._names, robots, self._given['limits'], self.warn)
        self.laws = load_laws(self._given['algo'], self.nb_robots, self._given['settings'])
        scripts = [(law.names, law.path) for law in self.laws]
        self._references = references_of_fleet(scripts, self.nb_robots, self.warn)

    def run(
        self,
        tables: RunTables,
        call_time: Floats,
        laws: ErrorReports,
        conditions: ErrorReports | None,
    ) -> Run:
        """Return the run that was made.

        Args:
            tables: What happened, but for references.
            call_time: How long a call of each law takes in s.
            laws: When they failed.
            conditions: When triggering conditions failed, if there are any.
        """
        failed_models = [robot for robot, one in enumerate(self.models, 1) if one.failed]
        outcome = Outcome.of_failures(
            failures([law.path.name for law in self.laws], laws.failed_robots)
            | failures(self._names, failed_models),
            {condition_name(self._given['ctc']): conditions.failed_robots} if conditions else {},
        )
        failed = sorted(
            [*laws.failures, *(conditions.failures if conditions else [])], key=attrgetter('t')
        )
        info = RunInfo(
            outcome=outcome,
            parameters=self._parameters(),
            seed=self.seed,
            failures=failed or None,
        )
        tables = replace(tables, references=self._references)
        return Run(tables, info, (*given_scripts(self.laws), *self._inputs), call_time)

    def _parameters(self) -> dict[str, Any]:
        return {
            'algo': name_of(self._given['algo']),
            'script': script_entry(self.laws),
            'set': dict(self._given['settings'] or {}),
            'duration': self._given['duration'],
            **self.gains.record(),
            **self._options.record(),
            **self.safety.record(),
            'ctc': name_of(self._given['ctc']),
            'graph': graph_entry(self._given['graph']),
            **self._simulation.record(),
            'pose': [] if self._simulation.random_poses else pose_options(self.start),
        }


def _start(simulation: SimulationOptions, nb_robots: int, poses: ArrayLike | None) -> Floats:
    if poses is None:
        return simulation.start_poses(nb_robots)
    if simulation.random_poses:
        raise ClashError('{} and {} both say where robots start', 'poses', 'random_poses')
    start = np.array(poses, dtype=float)
    if start.shape != (3, nb_robots) or not np.isfinite(start).all():
        raise SetcmasError(
            f'poses have shape {start.shape}; they must be finite numbers of shape '
            f'(3, {nb_robots})'
        )
    return start


def _check_size(nb_steps: int, nb_robots: int) -> None:
    nb_states = nb_steps * nb_robots
    if nb_states > MAX_STATES:
        raise SetcmasError(
            f'the run has {nb_states:.3g} states of robots and would take about '
            f'{nb_states * _BYTES_A_STATE / 1e9:.3g} GB; it must be {MAX_STATES:.3g} at most: '
            'take a shorter duration, fewer robots, or a lower robot rate'
        )
