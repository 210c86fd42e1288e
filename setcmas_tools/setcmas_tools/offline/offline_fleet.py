"""A simulated fleet without ROS: its laws, commands and messages, by the nodes' own functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import repeat
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication.communication_options import Communication
from setcmas_ctrl.communication.delay_and_loss import Links
from setcmas_ctrl.communication.graph import GraphChanges
from setcmas_ctrl.communication.message_content import Content, Value
from setcmas_ctrl.communication.triggering_conditions import CONSEQUENCE
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import GainOptions, LawOptions
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports
from setcmas_ctrl.laws.script_search import LawScripts
from setcmas_ctrl.saturation import saturate
from setcmas_ctrl.si_to_uni import Conversion
from setcmas_ctrl.velocity_conversion import VelocityConversion
from setcmas_simu.arrays import Floats, single_precision
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import check_in_fleet, format_per_robot, format_robots
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.script_calls import Function
from setcmas_tools.offline import run_progress
from setcmas_tools.run.run_records import (
    CommunicationRecord,
    Counts,
    SentMessage,
    record_of,
)


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
            scripts,
        )
        self._filter = None
        if options.is_on:  # loads the solver only if needed
            from setcmas_ctrl.safety_filter import SafetyFilter

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


class OfflineCommunication:
    """Messages between the robots of a simulated fleet.

    Attributes:
        is_on: Whether there are links. Robots that know all poses have none until a law uses
            messages.
        t: Time of the current calls in s.
        sent: Messages that laws have sent.
        reports: Errors of triggering conditions.
    """

    def __init__(
        self, communication: Communication, nb_robots: int, warn: Callable[[str], None]
    ) -> None:
        """Load triggering conditions, or raise SetcmasError; `warn` shows when one fails."""
        robots = range(1, nb_robots + 1)
        self.is_on = not communication.is_ideal
        self.t = 0.0
        self.sent: list[SentMessage] = []
        self._communication = communication
        self.reports = ErrorReports(warn, CONSEQUENCE, function=Function.CONDITION)
        self._broadcasts = (
            [communication.broadcast(robot, self.reports) for robot in robots]
            if communication.event_triggered
            else []
        )
        self._nb_robots = nb_robots
        self._all = np.arange(nb_robots)
        self._poses: Floats = np.full((3, nb_robots), np.nan)
        self._times: list[float] = []
        self._triggered: list[NDArray[np.bool_]] = []
        self._changes = GraphChanges(nb_robots)
        self._begun = False

    @cached_property
    def _links(self) -> Links:
        return self._communication.links(range(1, self._nb_robots + 1))

    def measure(self, poses: Floats, V: Floats, t: float) -> None:
        """Send the states of the robots whose conditions trigger at time t (s).

        The states are poses (3, N) in m and rad, and forward speeds V (N,) in m/s.
        """
        if not self._communication.event_triggered:
            self._links.send(self._all, poses, t)
            return
        self._times.append(t)
        triggered = self._triggered_by(poses, V, t)
        self._triggered.append(triggered)
        senders = triggered.nonzero()[0]
        if len(senders):
            self._links.send(senders, poses[:, senders], t)

    def _triggered_by(self, poses: Floats, V: Floats, t: float) -> NDArray[np.bool_]:
        states = zip(self._broadcasts, poses.T.tolist(), V.tolist(), strict=True)
        call = run_progress.current.call
        results: list[bool] = []
        for one, (x, y, theta), speed in states:
            call.begin(len(results) + 1, one.path, Function.CONDITION)
            results.append(one.is_triggered((x, y, theta), speed, t))
        call.end()
        return np.array(results)

    def known_poses(self, poses: Floats, t: float) -> tuple[Iterable[Floats], Floats | None]:
        """Return the poses that each robot knows at time t (s), and the adjacency matrix.

        Poses (3, N) are NaN for robots from which it receives nothing. Without links all robots
        know all poses, and there is no matrix.
        """
        self._poses, self.t = poses, t
        if not self.is_on:
            return repeat(poses), None
        adjacency = self._communication.graph.adjacency(t, poses[:2])
        if self._begun:
            self._links.connect(adjacency, t)
        else:
            self._links.begin(adjacency)
        self._changes.note(t if self._begun else 0.0, adjacency)
        self._begun = True
        known = self._links.known_poses(poses, t)
        for one, received, weights in zip(self._broadcasts, known, adjacency, strict=False):
            one.see(received, poses, weights)
        return known, adjacency

    def begin(self) -> None:
        """Let there be links, over which the robots have sent their poses already."""
        if not self.is_on:
            self.is_on = True
            self._links.send(self._all, self._poses, self.t)
            self.known_poses(self._poses, self.t)

    def send(self, robot: int, value: Value) -> None:
        """Let the next states that a robot sends carry a value."""
        self.sent.append(SentMessage(self.t, robot, value))
        self._links.attach(robot - 1, Content(self.t, value))

    def received(self, robot: int) -> Mapping[int, Content]:
        """Return what a robot has received last, by the numbers of the senders."""
        contents = self._links.contents(robot - 1) if self.is_on else {}
        return {sender + 1: content for sender, content in contents.items()}

    def record(self, times: Floats) -> CommunicationRecord | None:
        """Return the record of all messages, for robots with states at these times (s).

        None if there were no links.
        """
        if not self.is_on:
            return None
        counts = self._links.counts
        was_up = counts.sent > 0
        for _, receiver, sender, _ in self._changes.rows:
            was_up[receiver - 1, sender - 1] = True
        columns = counts.sent, counts.received, counts.lost, counts.mean_interval
        links = {
            (i + 1, j + 1): Counts(*(column[i, j].item() for column in columns))
            for i, j in np.argwhere(was_up).tolist()
        }
        sent = np.array(self._triggered, dtype=float).reshape(-1, self._nb_robots)
        evaluated = np.array(self._times)
        robots = np.tile(np.arange(1.0, self._nb_robots + 1), len(evaluated))
        triggers = np.column_stack(
            [np.repeat(evaluated, self._nb_robots), robots, sent.reshape(-1, 1)]
        )
        broadcasts = dict.fromkeys(range(1, self._nb_robots + 1), times)
        return record_of(links, triggers, self._changes.rows, broadcasts)
