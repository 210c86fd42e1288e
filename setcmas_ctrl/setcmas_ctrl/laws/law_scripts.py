"""The control scripts of a fleet: one for all robots, or '1:leader.py,2-8:follower.py'."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from setcmas_ctrl.laws.control_law import ControlLaw
from setcmas_ctrl.laws.exercise import unfilled_note
from setcmas_ctrl.laws.script_loader import ALGORITHMS, compile_script, find_script, names_to_set
from setcmas_ctrl.laws.script_settings import Settings
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import (
    check_in_fleet,
    format_per_robot,
    format_robots,
    is_per_robot,
    parse_per_robot,
)


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
