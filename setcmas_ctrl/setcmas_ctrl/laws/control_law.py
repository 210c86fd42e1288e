"""Control laws: the student's function of one robot, and the scripts of a fleet.

A fleet has one script for all robots, or some: '1:leader.py,2-8:follower.py'.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.exercise import unfilled_note
from setcmas_ctrl.laws.script_errors import ControlError, unknown_robots_note
from setcmas_ctrl.laws.script_function import ScriptFunction, checked_function, file_of
from setcmas_ctrl.laws.script_imports import helper_files
from setcmas_ctrl.laws.script_loader import (
    ALGORITHMS,
    compile_script,
    load_script,
    names_to_set,
)
from setcmas_ctrl.laws.script_search import find_script
from setcmas_ctrl.laws.script_settings import Settings
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import (
    check_in_fleet,
    format_per_robot,
    format_robots,
    is_per_robot,
    parse_per_robot,
)

Velocity = tuple[float, float]
_RAISED_BY_NAN = (ValueError, FloatingPointError)  # by int, round, numpy.linalg, scipy


class ControlLaw:
    """The control law of one robot, with its own state.

    Attributes:
        path: The script, or the file of the function.
        robot: The number of its robot.
        nb_robots: Size of the fleet.
        names: Top-level names of the script, or of the module of the function, and their values.
        files: The script, and its helper modules imported so far; none of a function.
    """

    def __init__(
        self,
        law: Path | Callable[..., Any],
        robot: int,
        nb_robots: int,
        settings: Settings | None = None,
    ) -> None:
        """Take a function, or load the script for a robot; settings replace values (`--set`).

        Raises:
            SetcmasError: The script does not load, or the function takes other arguments.
        """
        self.robot, self.nb_robots = robot, nb_robots
        self._module = None
        if isinstance(law, Path):
            self.path = law
            self._module = load_script(law, robot, settings=settings)
            self.names: Mapping[str, Any] = vars(self._module)
            law = self.names.get('control', law)
        else:
            self.path = file_of(law, 'control')
            self.names = getattr(law, '__globals__', {})
        function = checked_function(law, self.path)
        self._control = ScriptFunction(
            function, self.path, 'control', expected='two finite numbers: return vx, vy'
        )

    @property
    def files(self) -> list[Path]:
        """The script, and its helper modules imported so far; none of a function."""
        return [self.path, *helper_files(self._module)] if self._module else []

    def __call__(self, poses: Floats, t: float) -> Velocity:
        """Return the velocity (vx, vy) in m/s from the script.

        Args:
            poses: Rows x, y in m and theta in rad, shape (3, N), NaN for robots whose poses
                this robot does not know; the script gets a copy.
            t: Time since the run started, in s.

        Raises:
            ControlError: The script raised, or did not return two finite numbers.
        """
        try:
            vx, vy = self._control(self.robot, self.nb_robots, poses.copy(), t)
        except ControlError as failure:
            cause = failure.__cause__
            note = unknown_robots_note(self.robot, poses)
            may_be_nan = isinstance(cause, _RAISED_BY_NAN) and getattr(cause, 'is_nan', True)
            if may_be_nan and note not in failure.message:
                failure.message += note
            raise
        return vx, vy


class LawScripts:
    """The control script of each robot, and the values that `--set` gives to each script.

    Attributes:
        paths: The scripts, without repetition.
    """

    def __init__(
        self, algo: str, exercise: bool = False, settings: Settings | None = None
    ) -> None:
        """Find and compile the scripts of `--algo`; each setting goes to those that assign it.

        Raises:
            SetcmasError: A script is missing or invalid, or no script assigns a name.
        """
        self._algo = algo
        named = parse_per_robot(algo, '--algo') if is_per_robot(algo) else None
        found = {name: find_script(name, exercise) for name in (named or {0: algo}).values()}
        self._found = found
        self.paths = list(dict.fromkeys(found.values()))
        self._by_robot = {robot: found[name] for robot, name in named.items()} if named else None
        self._settings = self._shared_out(settings or {})
        for path in self.paths:
            compile_script(path, settings=self._settings[path])

    @property
    def notes(self) -> list[str]:
        """Notes on scripts that hide a built-in law or are not filled in yet."""
        hiding = [
            f'--algo {name} runs {path.name} in this folder instead of the built-in law {name}; '
            'to run the built-in law, rename the file'
            for name, path in self._found.items()
            if name in ALGORITHMS and path.parent == Path.cwd()
        ]
        return hiding + list(filter(None, map(unfilled_note, self.paths)))

    @property
    def use_network(self) -> bool:
        """Whether scripts import the communication network."""
        return any(b'import network' in path.read_bytes() for path in self.paths)

    @property
    def text(self) -> str:
        """Value of `--algo` for these scripts that works in any folder."""
        if not self._by_robot:
            return str(self.paths[0])
        return format_per_robot({robot: str(path) for robot, path in self._by_robot.items()})

    def check(self, nb_robots: int, others: Collection[int] = ()) -> None:
        """Raise SetcmasError unless exactly the robots of the fleet, except others, have one."""
        if self._by_robot is None:
            return
        check_in_fleet(self._by_robot, nb_robots, '--algo')
        known = {*self._by_robot, *others}
        if missing := [robot for robot in range(1, nb_robots + 1) if robot not in known]:
            robots = format_robots(missing)
            raise SetcmasError(
                f"--algo '{self._algo}' has no control law for robot{'s' * (len(missing) > 1)} "
                f'{robots}; add it, such as {robots}:consensus'
            )

    def script(self, robot: int) -> Path:
        """Return the script of a robot."""
        return self._by_robot[robot] if self._by_robot else self.paths[0]

    def law(self, robot: int, nb_robots: int) -> ControlLaw:
        """Return the control law of a robot, with its own state, or raise SetcmasError."""
        path = self.script(robot)
        return ControlLaw(path, robot, nb_robots, self._settings[path])

    def _shared_out(self, settings: Settings) -> Mapping[Path, Settings]:
        """Return the settings of each script."""
        if len(self.paths) == 1 or not settings:
            return dict.fromkeys(self.paths, settings)
        for path in self.paths:
            compile_script(path)  # report its mistakes before looking for names
        names = {path: names_to_set(path) for path in self.paths}
        for name in settings:
            if not any(name in own for own in names.values()):
                has = '; '.join(
                    f'{path.name} has {", ".join(sorted(own)) or "none"}'
                    for path, own in names.items()
                )
                raise SetcmasError(f'setting {name}: no control script assigns it: {has}')
        return {
            path: {name: value for name, value in settings.items() if name in own}
            for path, own in names.items()
        }
