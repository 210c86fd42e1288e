"""Altered solutions: what they would have answered at the calls of a submission.

The run of a submission is repeated from its recorded output, and at each call the solution and
altered solutions get the same input. So an altered solution with the submission's mistake agrees
with it at every call, however far both are from the paths of the solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl import network
from setcmas_ctrl.communication.message_content import Mailbox, Value
from setcmas_ctrl.communication.triggering_conditions import further_than
from setcmas_ctrl.laws.script_imports import with_helpers
from setcmas_ctrl.laws.script_loader import load_script, names_to_set
from setcmas_ctrl.si_to_uni import si_to_uni
from setcmas_simu.arrays import Floats
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.rubric import SUBMITTED, TypicalMistake
from setcmas_tools.offline.offline_simulation import silent, simulate
from setcmas_tools.run.fleet_motion import FleetTable
from setcmas_tools.run.run import Run
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.submissions.robot_functions import RobotFunction, asking, robot_function

CLOSE = 0.011
"""Difference of velocities in m/s up to which calls agree: a little more than the dead band."""
_MAY_DIFFER = {Function.CONTROL: 0.03, Function.CONDITION: 0.001, Function.SI_TO_UNI: 0.03}
"""Share of calls that may differ, by the function: a right law may take its next waypoint a call
earlier.
"""
SATURATED = 0.98
"""Share of the largest speed from which on a velocity is saturated."""
_PATH_M = 0.01  # between a run and its repetition


@dataclass
class Altered:
    """A solution, altered or not.

    Attributes:
        name: What is altered.
        script: Its file; None for the default condition.
        constant: Name of a number of the script that is doubled; '' for none.
        is_frozen: Whether it always gets t = 0.
        is_kept: Whether it is not given up when too many of its answers differ.
        is_out: Whether it is given up.
    """

    name: str
    script: Path | None
    constant: str = ''
    is_frozen: bool = False
    is_kept: bool = False
    is_out: bool = False


SOLUTION, FROZEN = '', 't = 0'
"""Names of the solution, and of the solution that always gets t = 0."""


def altered_solutions(
    solution: Path | None, mistakes: Sequence[TypicalMistake], function: Function, folder: Path
) -> list[Altered]:
    """Return the solution, and those with one alteration, some of which are written to a folder.

    Those with a mistake of the rubric have its number as name; those with a constant its name.
    """
    found = [Altered(SOLUTION, solution, is_kept=True)]
    if solution and function is Function.CONTROL:
        found.append(Altered(FROZEN, solution, is_frozen=True))
        found += [Altered(name, solution, name, is_kept=True) for name in _constants(solution)]
    for number, one in enumerate(mistakes):
        altered = _written(str(number), one.source(solution), solution, folder)
        found.append(replace(altered, is_kept=bool(one.term)))
    return found


def _written(name: str, source: str, solution: Path | None, folder: Path) -> Altered:
    """Write an altered solution to a folder, with the modules that it imports."""
    for file in with_helpers(solution)[1:] if solution else ():
        (folder / file.name).write_bytes(file.read_bytes())
    script = folder / f'mistake_{name}.py'
    script.write_text(source, encoding='utf-8')
    return Altered(name, script)


def _constants(script: Path) -> list[str]:
    """Return the names of the numbers at the top level of a script, except those that are 0."""
    values = vars(load_script(script, 1))
    numbers = ((name, values.get(name)) for name in names_to_set(script))
    return [name for name, value in numbers if type(value) in (int, float) and value]


@dataclass
class Calls:
    """What a submission answered at its calls in a scenario, and what solutions would answer.

    Answers have the shape (calls, N, 2): velocities in m/s before saturation; for conditions,
    whether the robot sends (1 or 0), and 0; for si_to_uni, V in m/s and omega in rad/s.

    Attributes:
        name: Name of the scenario.
        scenario: The scenario without the submission.
        t: Times of the calls in s.
        own: Answers of the submission; velocities after saturation.
        limit: Largest speed in m/s; inf unless answers are velocities.
        heading: Heading of the robot at each call in rad, shape (calls, N); 0 for conditions.
        distance_to_sent: Distance of the robot from the position that it sent last, in m, for
            conditions; shape (calls, N).
        may_differ: Share of the calls in which equal laws may differ.
        answers: Answers of the solution and of altered ones that are not out, by name.
        values: Values of the constants.
    """

    name: str
    scenario: Scenario
    t: Floats
    own: Floats
    limit: float
    heading: Floats
    distance_to_sent: Floats
    may_differ: float
    answers: dict[str, Floats] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)

    @property
    def solution(self) -> Floats:
        """Answers of the solution."""
        return self.answers[SOLUTION]

    @property
    def is_known(self) -> NDArray[np.bool_]:
        """Where the solution is outside its dead band, so that its multiples are known."""
        return _lengths(self.solution) > 0

    @property
    def is_free(self) -> NDArray[np.bool_]:
        """Where, in addition, the submission is not saturated."""
        return self.is_known & (self.speeds < SATURATED * self.limit)

    @property
    def speeds(self) -> Floats:
        """Lengths of the submission's answers."""
        return _lengths(self.own)

    def of_robots(self, which: NDArray[np.bool_]) -> Calls:
        """Return the calls of some of the robots; which has the shape (N,)."""
        answers = {name: each[:, which] for name, each in self.answers.items()}
        return replace(
            self,
            own=self.own[:, which],
            heading=self.heading[:, which],
            distance_to_sent=self.distance_to_sent[:, which],
            answers=answers,
        )

    def differs(self, answers: Floats) -> NDArray[np.bool_]:
        """Return where answers differ from those of the submission, shape (calls, N)."""
        return ~(_lengths(saturated(answers, self.limit) - self.own) <= CLOSE)


def saturated(velocities: Floats, limit: float) -> Floats:
    """Return velocities, shape (..., 2), scaled down to a largest speed in m/s."""
    speed = np.maximum(_lengths(velocities), 1e-12)
    return velocities * np.minimum(1.0, limit / speed)[..., None]


def _lengths(vectors: Floats) -> Floats:
    """Return the lengths of vectors, shape (..., 2)."""
    return np.hypot(vectors[..., 0], vectors[..., 1])


def calls_of(
    name: str, base: Scenario, run: Run, function: Function, altered: Sequence[Altered]
) -> Calls | None:
    """Return the calls of a submission's run; altered solutions that differ are out from now on.

    None if the run cannot be repeated. Raises SetcmasError if a script does not load.
    """
    rows = _recorded(run, function, base.nb_robots)
    if not rows or len({len(one) for one in rows}) > 1 or not len(rows[0]):
        return None
    own = np.stack([one[:, 1:] for one in rows], axis=1)
    limit = base.law.vnom if function is Function.CONTROL else np.inf
    may_differ = _MAY_DIFFER[function]
    heading, distance_to_sent = np.zeros(own.shape[:2]), np.zeros(own.shape[:2])
    calls = Calls(name, base, rows[0][:, 0], own, limit, heading, distance_to_sent, may_differ)
    replays = [_Replayed(one, calls, function) for one in altered if not one.is_out]
    sent = {(one.robot, round(one.t, 6)): one.value for one in run.messages}
    repeated = {
        robot: asking(function, _repeating(robot, calls, replays, function, sent))
        for robot in range(1, base.nb_robots + 1)
    }
    played = base.replace(set={}) if function is Function.CONTROL else base
    played = played.replace(**{SUBMITTED[function][0]: repeated})
    with silent():
        again = simulate(played, warn=lambda _: None)
    calls.answers |= {one.altered.name: one.answers for one in replays if not one.altered.is_out}
    return calls if SOLUTION in calls.answers and _are_equal(run, again) else None


def _recorded(run: Run, function: Function, nb_robots: int) -> list[Floats]:
    """Return rows t and answer of the calls of each robot; nothing if there is no record."""
    robots = range(1, nb_robots + 1)
    if function is not Function.CONDITION and run.commands:
        owns = map(run.commands.of, robots)
        if function is Function.CONTROL:
            return [np.column_stack([own.t, own.vx, own.vy]) for own in owns]
        return [_driven(own.t, run.table.of(i)) for i, own in zip(robots, owns, strict=True)]
    if function is not Function.CONDITION or not run.record:
        return []
    # The first state is sent whatever the condition is.
    rows = [run.record.triggers[run.record.triggers[:, 1] == i][1:] for i in robots]
    return [np.column_stack([one[:, 0], one[:, 2], 0 * one[:, 2]]) for one in rows]


def _driven(t: Floats, table: FleetTable) -> Floats:
    """Return rows t, V, omega of the commands at times t (s), from the next state after each."""
    after = np.searchsorted(table.t, t + 1e-6, side='right')
    return np.column_stack([t, table.v[after], table.omega[after]])


def _are_equal(run: Run, again: Run) -> bool:
    one, other = run.table, again.table
    if one.x.shape != other.x.shape:
        return False
    return bool(np.nanmax(np.hypot(one.x - other.x, one.y - other.y), initial=0.0) < _PATH_M)


class _Replayed:
    """An altered solution in a scenario: the function of each robot, and its answers."""

    def __init__(self, altered: Altered, calls: Calls, function: Function) -> None:
        self.altered = altered
        self.answers: Floats = np.full(calls.own.shape, np.nan)
        self._calls, self._function = calls, function
        self._laws: dict[int, Callable[..., Any]] = {}
        self._left = calls.may_differ * calls.own.shape[0] * calls.own.shape[1]

    def answer(self, robot: int, call: int, *given: Any) -> None:
        """Answer a call; given are the arguments of the law, condition or si_to_uni."""
        if self.altered.is_out:
            return
        try:
            if robot not in self._laws:
                self._laws[robot] = self._law(robot)
            if self.altered.is_frozen:
                given = (given[0], 0.0, *given[2:])
            answer = self._laws[robot](*given)
        except Exception:  # it fails where the submission does not
            self.altered.is_out = True
            return
        if self._function is Function.CONDITION:
            answer = (*answer, 0.0)
        self.answers[call, robot - 1] = answer
        if not self.altered.is_kept:
            own = self._calls.own[call, robot - 1]
            apart = saturated(np.array(answer, dtype=float), self._calls.limit) - own
            self._left -= bool(apart @ apart > CLOSE * CLOSE)
            self.altered.is_out = self._left < 0

    def _law(self, robot: int) -> RobotFunction:
        """Load the law, condition or si_to_uni of a robot."""
        base, script = self._calls.scenario, self.altered.script
        settings = dict(base.law.set) if self._function is Function.CONTROL else {}
        if script and (name := self.altered.constant):
            own = settings.get(name, vars(load_script(script, robot))[name])
            self._calls.values[name] = own
            settings[name] = 2 * own
        built_in = {
            Function.CONDITION: further_than(base.communication.threshold),
            Function.SI_TO_UNI: _built_in,
        }
        chosen = script or built_in[self._function]
        return robot_function(self._function, chosen, robot, base.nb_robots, settings)


def _repeating(
    robot: int,
    calls: Calls,
    replays: Sequence[_Replayed],
    function: Function,
    sent: Mapping[tuple[int, float], Value],
) -> RobotFunction:
    """Return a robot's function that answers as the submission did, and asks solutions."""
    numbers = iter(range(len(calls.t)))

    def answer(*given: Any) -> tuple[float, ...]:
        call, is_law = next(numbers), function is Function.CONTROL
        if function is Function.CONDITION:
            pos, _, last_pos, *_ = given
            calls.distance_to_sent[call, robot - 1] = np.hypot(*(pos - last_pos)[:2])
        else:
            heading = given[0][2, robot - 1] if is_law else given[1][2]
            calls.heading[call, robot - 1] = heading
        with network.exchanged_by(Mailbox(given[1], network.contents()) if is_law else None):
            for one in replays:
                one.answer(robot, call, *given)
        if is_law and (key := (robot, round(given[1], 6))) in sent:
            network.send(sent[key])
        return tuple(calls.own[call, robot - 1].tolist())

    return answer


def _built_in(
    velocity: tuple[float, float], pose: tuple[float, float, float], komega: float
) -> Any:
    """Return V and omega by the built-in si_to_uni."""
    return si_to_uni(velocity, pose[2], komega)
