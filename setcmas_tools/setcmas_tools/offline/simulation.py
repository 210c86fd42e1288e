"""One simulated run: what `simulate` was given, what it needs on the way, and what it leaves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from setcmas_ctrl.communication.options import CommunicationOptions, Condition, Graph
from setcmas_ctrl.communication.settings import Communication, chosen_communication
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.options import GainOptions
from setcmas_ctrl.filter.options import FilterOptions
from setcmas_ctrl.filter.starts import check_starts
from setcmas_ctrl.scripts.error_reports import ErrorReports
from setcmas_ctrl.scripts.settings import Settings
from setcmas_ctrl.task.references import References, told_references
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.group import ClashError
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.models import absolute, check_models, model_names, robot_models
from setcmas_simu.simulator.options import SimulationOptions
from setcmas_simu.world.obstacles import ObstaclesKind
from setcmas_tools.offline.fleet_laws import Algo, load_laws
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
from setcmas_tools.records.tables import RunTables
from setcmas_tools.run.info import RunInfo
from setcmas_tools.run.inputs import RunInput, model_inputs
from setcmas_tools.run.options import RunOptions
from setcmas_tools.run.outcome import Outcome
from setcmas_tools.run.run import Run

MAX_STATES = 10_000_000
"""The most states of robots in a run, a state a robot and step; they are held in memory."""

_BYTES_A_STATE = 500  # measured: 150 to 220, and once more while the run changes processes


@dataclass(kw_only=True)
class Simulation:
    """A run to be simulated: the arguments of `simulate`, and what follows from them.

    Attributes:
        start: Start poses, shape (3, nb_robots).
        nb_steps: How many steps the robots make.
        gains: Those of the laws.
        safety: What keeps robots apart.
        tells: How the robots communicate.
        models: How each robot moves; there are none before `load`, nor laws.
        laws: That of each robot.
    """

    algo: Algo
    nb_robots: int
    duration: float
    poses: ArrayLike | None
    random_poses: str | None
    model: str | None
    limits: str
    vnom: float
    komega: float
    rate: float
    robot_rate: float
    seed: int
    settings: Settings | None
    graph: Graph
    range: float | None
    event_triggered: bool
    ctc: Condition
    threshold: float
    delay: float
    loss: float
    noise: float
    filter: str | None
    deadlock: str
    min_separation: float | None
    gamma: float
    lookahead: float
    arena: Sequence[float] | None
    obstacles: str | None
    accel: float | None
    warn: Callable[[str], None]
    progress: Callable[[float], object] | None
    start: Floats = field(init=False)
    nb_steps: int = field(init=False)
    gains: GainOptions = field(init=False)
    safety: FilterOptions = field(init=False)
    tells: Communication = field(init=False)
    models: list[RobotModel] = field(init=False)
    laws: list[ControlLaw] = field(init=False)
    _simulation: SimulationOptions = field(init=False)
    _options: CommunicationOptions = field(init=False)
    _names: list[str] = field(init=False)
    _inputs: list[RunInput] = field(init=False)
    _references: References | None = field(init=False)

    def __post_init__(self) -> None:
        """Check the arguments, before a script is loaded.

        Raises:
            SetcmasError: One makes no sense.
        """
        RunOptions(duration=self.duration)
        self._simulation = SimulationOptions(
            nb_robots=self.nb_robots,
            random_poses=self.random_poses,
            model=self.model,
            limits=self.limits,
            robot_rate=self.robot_rate,
            seed=self.seed,
        )
        self.gains = GainOptions(
            vnom=self.vnom, komega=self.komega, rate=self.rate, seed=self.seed
        )
        self.safety = FilterOptions(
            filter=self.filter,
            deadlock=self.deadlock,
            min_separation=self.min_separation,
            gamma=self.gamma,
            lookahead=self.lookahead,
            arena=self.arena,
            obstacles=self.obstacles and ObstaclesKind().parse(self.obstacles),
            accel=self.accel,
        )
        self.nb_steps = self._simulation.nb_steps(self.duration)
        _check_size(self.nb_steps, self.nb_robots)
        self.start = _start(self._simulation, self.nb_robots, self.poses)
        check_starts(self.safety, self.start)
        self._options = CommunicationOptions(
            graph=self.graph,
            range=self.range,
            event_triggered=self.event_triggered,
            ctc=self.ctc,
            threshold=self.threshold,
            delay=self.delay,
            loss=self.loss,
            noise=self.noise,
        )
        self.tells = chosen_communication(self.nb_robots, self._options, self.seed)
        names = model_names(self.model, self.nb_robots)
        check_models(names, self.limits)
        # Files are found before a script is loaded: it may change the current folder.
        self._names = absolute(names)
        self._inputs = [
            *model_inputs(self.model, self.nb_robots),
            *given_files(self.tells.condition_script, self.graph),
        ]

    def load(self) -> None:
        """Load the scripts of laws and robots.

        Raises:
            SetcmasError: One cannot be loaded.
        """
        robots = range(1, self.nb_robots + 1)
        self.models = robot_models(self._names, robots, self.limits, self.warn)
        self.laws = load_laws(self.algo, self.nb_robots, self.settings)
        scripts = [(law.names, law.path) for law in self.laws]
        self._references = told_references(scripts, self.nb_robots, self.warn)

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
            {condition_name(self.ctc): conditions.failed_robots} if conditions else {},
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
            'algo': name_of(self.algo),
            'script': script_entry(self.laws),
            'set': dict(self.settings or {}),
            'duration': self.duration,
            **self.gains.record(),
            **self._options.record(),
            **self.safety.record(),
            'ctc': name_of(self.ctc),
            'graph': graph_entry(self.graph),
            **self._simulation.record(),
            'pose': [] if self.random_poses else pose_options(self.start),
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
