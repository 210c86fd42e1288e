"""The control scripts of a fleet: one for all robots, or '1:leader.py,2-8:follower.py'."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.exercise import unfilled_note
from setcmas_ctrl.scripts.loader import ALGORITHMS, compile_script, find_script, names_to_set
from setcmas_ctrl.scripts.script_settings import Settings
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.fleet.per_robot import (
    check_in_fleet,
    format_per_robot,
    is_per_robot,
    parse_per_robot,
)


class LawScripts:
    """Which robot runs which control script, and the values that `--set` gives each script.

    Attributes:
        paths: The scripts, each once.
    """

    def __init__(
        self, algo: str, exercise: bool = False, settings: Settings | None = None
    ) -> None:
        """Find and compile the scripts.

        Args:
            algo: What `--algo` says.
            exercise: Whether names mean exercises.
            settings: Values for names of the scripts; each goes to the scripts that assign it.

        Raises:
            SetcmasError: A script is missing or has a mistake, or none assigns a name.
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
        """What to say of scripts that hide a built-in law, or are not filled in yet."""
        hiding = [
            f'--algo {name} is {path.name} in this folder, which hides the built-in law of that '
            'name; rename the file to run that one'
            for name, path in self._found.items()
            if name in ALGORITHMS and path.parent == Path.cwd()
        ]
        return hiding + list(filter(None, map(unfilled_note, self.paths)))

    @property
    def title(self) -> str:
        """The scripts' names without their suffix, such as 'leader, follower'."""
        return ', '.join(path.stem for path in self.paths)

    @property
    def name(self) -> str:
        """The script, or the names of several, for a record."""
        return self.title if self._by_robot else str(self.paths[0])

    @property
    def text(self) -> str:
        """What means these scripts to `--algo`, wherever they were found."""
        if not self._by_robot:
            return str(self.paths[0])
        return format_per_robot({robot: str(path) for robot, path in self._by_robot.items()})

    @property
    def robots_of(self) -> dict[Path, tuple[int, ...]]:
        """The robots of each script; none where one script is for all robots."""
        by_robot = self._by_robot or {}
        return {
            path: tuple(sorted(robot for robot, own in by_robot.items() if own == path))
            for path in self.paths
        }

    def check(self, nb_robots: int, others: Collection[int] = ()) -> None:
        """See that each robot of a fleet has a script, and no other one.

        Args:
            nb_robots: Size of the fleet.
            others: Robots that need none.

        Raises:
            SetcmasError: It is not so.
        """
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
        """Return the control law of a robot of a fleet, with a state of its own.

        Raises:
            SetcmasError: The script cannot be loaded.
        """
        path = self.script(robot)
        return ControlLaw(path, robot, nb_robots, self._settings[path])

    def _shared_out(self, settings: Settings) -> Mapping[Path, Settings]:
        """Return which script gets which settings."""
        if len(self.paths) == 1 or not settings:
            return dict.fromkeys(self.paths, settings)
        for path in self.paths:
            compile_script(path)  # a mistake is told before its names are looked for
        names = {path: names_to_set(path) for path in self.paths}
        for name in settings:
            if not any(name in own for own in names.values()):
                has = '; '.join(
                    f'{path.name} has {", ".join(sorted(own)) or "none"}'
                    for path, own in names.items()
                )
                raise SetcmasError(f'--set {name}: no control script assigns it: {has}')
        return {
            path: {name: value for name, value in settings.items() if name in own}
            for path, own in names.items()
        }
