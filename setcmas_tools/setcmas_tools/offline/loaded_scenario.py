"""Simulation: a checked scenario with its models and laws."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import repeat
from operator import attrgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.communication_settings import chosen_communication
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.control_options import Algo, LawOptions
from setcmas_ctrl.laws.references import References, references_of_fleet
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_ctrl.laws.script_search import LawScripts
from setcmas_ctrl.si_to_uni_script import ScriptConversion, script_conversions
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import check_in_fleet, format_per_robot
from setcmas_simu.fleet.planar_pose import through_quaternion
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.models_by_name import check_models, model_names, robot_models
from setcmas_simu.script_calls import Function
from setcmas_tools.offline import run_progress
from setcmas_tools.offline.offline_commands import Commanded, Commander
from setcmas_tools.run.fleet_motion import FleetTable
from setcmas_tools.run.inputs import inputs_of, kept_record
from setcmas_tools.run.law_output import Commands, Filtered
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import Outcome, RunInfo
from setcmas_tools.run.run_tables import RunTables
from setcmas_tools.run.scenario import Scenario, name_of


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
    call = run_progress.current.call
    laws = []
    for robot in robots:
        if robot in functions or scripts is None:
            laws.append(ControlLaw(functions[robot], robot, nb_robots))
            continue
        script = scripts.script(robot)
        call.begin(robot, script, Function.LOADING)
        laws.append(ControlLaw(script, robot, nb_robots, scripts.settings[script]))
        call.end()
    return laws


def _note_step(robot: int, path: Path) -> None:
    """Note a call of a robot script as the current one."""
    run_progress.current.call.begin(robot, path, Function.STEP)


@contextmanager
def _noted_call(robot: int, path: Path) -> Iterator[None]:
    """Note a call of an own conversion as the current one."""
    call = run_progress.current.call
    call.begin(robot, path, Function.SI_TO_UNI)
    try:
        yield
    finally:
        call.end()


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
        self._call = run_progress.current.call

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
        known_poses = repeat(poses) if received is None else received
        for law, known in zip(self._laws, known_poses, strict=False):
            self._call.begin(law.robot, law.path)
            try:
                wanted += law(known, t, adjacency)
                self.reports.succeeded(law.robot, t)
            except ControlError as error:
                wanted += (0.0, 0.0)
                self.reports.failed(law.robot, t, error)
        self._call.end()
        return self._commander(np.fromiter(wanted, float).reshape(-1, 2).T, poses)


MAX_STATES = 10_000_000
"""The most states of robots in a run, a state a robot and step; they are held in memory."""

_BYTES_A_STATE = 500  # measured: 150 to 220, and once more while the run changes processes


class Simulation:
    """A scenario that can be simulated.

    Attributes:
        warn: Shows messages.
        progress: Called with the time of the run so far in s; may be None.
        start: Start poses, shape (3, nb_robots).
        nb_steps: Number of steps of the robots.
        communication: Settings of the communication.
        models: Model of each robot, from `load` on.
        laws: Law of each robot, from `load` on.
        conversions: Own conversion of each robot, from `load` on; none by default.
    """

    models: list[RobotModel]
    laws: list[ControlLaw]
    conversions: list[ScriptConversion]
    _references: References | None

    def __init__(
        self,
        scenario: Scenario,
        warn: Callable[[str], None] = print,
        progress: Callable[[float], object] | None = None,
    ) -> None:
        """Raise SetcmasError unless the scenario can be simulated, before a script is loaded."""
        self.scenario = scenario
        self.nb_robots = scenario.nb_robots
        self.seed = scenario.seed
        self.warn = warn
        self.progress = progress
        robots = scenario.robots
        self.nb_steps = checked_steps(scenario)
        self.start = scenario.start_poses()
        # Files are found before a script is loaded: it may change the current folder.
        self._found = found = scenario.found()
        self._inputs = inputs_of(found)
        self.communication = chosen_communication(self.nb_robots, found.communication, self.seed)
        self._conversion_reports = ErrorReports(warn, function=Function.SI_TO_UNI)
        self._models = model_names(found.robots.model, self.nb_robots)
        check_models(self._models, robots.limits)

    def load(self, time: Callable[[], float]) -> None:
        """Load the scripts of laws, conversions and robots, or raise SetcmasError.

        The time of the run, in s, is for messages.
        """
        robots = range(1, self.nb_robots + 1)
        limits = self.scenario.robots.limits
        self.models = robot_models(self._models, robots, limits, self.warn, _note_step)
        self.laws = load_laws(self._found.law, self.nb_robots)
        self.conversions = script_conversions(
            self._found.law.si_to_uni, robots, self._conversion_reports, time, _noted_call
        )
        scripts = [(law.names, law.path) for law in self.laws]
        self._references = references_of_fleet(scripts, self.nb_robots, self.warn)

    def run(self, tables: RunTables, laws: ErrorReports, conditions: ErrorReports | None) -> Run:
        """Return the finished run from its tables, and failures of laws and conditions."""
        failed_conversions = self._conversion_reports.failed_robots
        failed_models = [robot for robot, one in enumerate(self.models, 1) if one.failed]
        condition = Path(name_of(self._found.communication.ctc) or 'by default').name
        outcome = Outcome.of_failures(
            _by_script([law.path.name for law in self.laws], laws.failed_robots)
            | _by_script([one.path.name for one in self.conversions], failed_conversions)
            | _by_script(self._models, failed_models),
            {condition: conditions.failed_robots} if conditions else {},
        )
        failed = sorted(
            [
                *laws.failures,
                *self._conversion_reports.failures,
                *(conditions.failures if conditions else []),
            ],
            key=attrgetter('t'),
        )
        info = RunInfo(
            outcome=outcome,
            scenario=kept_record(self._found.replace(nb_robots=self.nb_robots), self._inputs),
            failures=failed or None,
        )
        tables = replace(tables, references=self._references)
        return Run(tables, info, tuple(self._inputs))


def checked_steps(scenario: Scenario) -> int:
    """Return the number of steps of the robots, or raise SetcmasError."""
    nb_steps = scenario.robots.nb_steps(scenario.time.duration)
    nb_states = nb_steps * scenario.nb_robots
    if nb_states > MAX_STATES:
        raise SetcmasError(
            f'the run would store {nb_states:.3g} states of robots (about '
            f'{nb_states * _BYTES_A_STATE / 1e9:.3g} GB); the limit is {MAX_STATES:.3g}: use a '
            'shorter duration, fewer robots, or a lower robot rate'
        )
    return nb_steps


def _by_script(names: Sequence[str], robots: Sequence[int]) -> dict[str, list[int]]:
    """Return some robots by the name of their script; `names` begins with that of robot 1."""
    failed: dict[str, list[int]] = {}
    for robot in robots:
        failed.setdefault(Path(names[robot - 1]).name, []).append(robot)
    return failed


def motion(t: Floats, poses: Floats, V: Floats, omega: Floats) -> FleetTable:
    """Return the table of a fleet's states: poses (K, 3, N) in m and rad, as simulated.

    Forward speeds V in m/s and turn rates in rad/s, shape (K, N), are those over the step that led
    to each state.
    """
    times, robots = _rows(t, poses.shape[2])
    x, y, theta = through_quaternion(poses.transpose(1, 0, 2).reshape(3, -1))
    return FleetTable(times, robots, x, y, theta, V.ravel(), omega.ravel())


def commands(t: Floats, velocities: Floats) -> Commands:
    """Return the commands of a fleet.

    Velocities (C, 2, N) in m/s are those wanted, after saturation; with a filter, (C, 5, N), also
    the allowed ones and its verdicts.
    """
    times, robots = _rows(t, velocities.shape[2])
    vx, vy, *allowed = velocities.transpose(1, 0, 2).reshape(velocities.shape[1], -1)
    return Commands(times, robots, vx, vy, Filtered(*allowed) if allowed else None)


def _rows(t: Floats, nb_robots: int) -> tuple[Floats, NDArray[np.int64]]:
    robots = np.arange(1, nb_robots + 1, dtype=np.int64)
    return np.repeat(t, nb_robots), np.tile(robots, len(t))
