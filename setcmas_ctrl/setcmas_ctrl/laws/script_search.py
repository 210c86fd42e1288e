"""Search of scripts: by path, in the current folder, and among those of installed packages.

A fleet has one control script for all robots, or some: '1:leader.py,2-8:follower.py'. A script may
solve an exercise, which has a solution.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from setcmas_ctrl.laws.script_function import CONTROL
from setcmas_ctrl.laws.script_loader import (
    ALGORITHMS,
    EXERCISES,
    compile_script,
    names_to_set,
    parsed,
    plain_values,
)
from setcmas_ctrl.laws.script_settings import Settings
from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.fleet.fleet import (
    check_in_fleet,
    format_per_robot,
    format_robots,
    is_per_robot,
    parse_per_robot,
)
from setcmas_simu.plugins import ScriptGroup
from setcmas_simu.script_calls import Function

_MOST_NAMES = 10


def find_script(
    name: str,
    exercise: bool = False,
    groups: Sequence[ScriptGroup] = (ALGORITHMS,),
    option: str = '--algo',
    form: str = CONTROL,
) -> Path:
    """Return the script that an option names, or raise SetcmasError with similar names.

    In this order: a path to a file; NAME.py in the current folder; with `exercise`, an exercise;
    a script of one of the groups, built in or of a plugin. The form is that of the function that
    it must define.
    """
    if path := _named_file(name):
        if path.suffix == '.ipynb':
            raise SetcmasError(
                f"'{path.name}' is a notebook; start its cell with "
                f'`%%writefile {path.stem}.py` and use {option} {path.stem}.py'
            )
        return path
    groups = (EXERCISES, *groups) if exercise else groups
    for group in groups:
        if name in group:
            return group.file(name)
    function = form.partition('(')[0]
    names = {f'{group.kind}s': list(group.plugins()) for group in groups}
    names[f'in this folder with a function {function}'] = [
        path.stem for path in scripts_in(Path.cwd()) if _defines(path, function)
    ]
    known = list(dict.fromkeys(stem for stems in names.values() for stem in stems))
    lists = '; '.join(f'{title}: {_first(stems)}' for title, stems in names.items())
    hint = did_you_mean(Path(name).stem, known, 3)
    raise SetcmasError(f"script '{name}' of {option} not found; {lists}{hint}")


def _named_file(name: str) -> Path | None:
    """Return the file with a path, or NAME.py in the current folder; None if there is none."""
    for path in (Path(name), Path(f'{name}.py')):
        with contextlib.suppress(OSError):  # such as a name that is too long
            if path.is_file():
                return path.resolve()
    return None


def _first(names: Sequence[str]) -> str:
    shown = [*names[:_MOST_NAMES], *(['...'] if len(names) > _MOST_NAMES else [])]
    return ', '.join(shown) or 'none'


def scripts_in(folder: Path) -> list[Path]:
    """Return the scripts in a folder, sorted by name."""
    paths = (path for path in folder.glob('*.py') if not path.name.startswith('_'))
    return sorted(path for path in paths if path.is_file())


_LISTED = {'control', 'ctc', 'si_to_uni'}
"""A listed script defines one of these: a law, a triggering condition, or a conversion."""


def _functions_of(tree: ast.Module) -> set[str]:
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def _defines(path: Path, function: str) -> bool:
    """Return whether a script defines a function; one that cannot be read does not."""
    with contextlib.suppress(SetcmasError):
        return function in _functions_of(parsed(path))
    return False


def summary_of(path: Path) -> str | None:
    """Return the first line of a script's docstring; None if it defines nothing to be listed."""
    try:
        tree = parsed(path)
    except SetcmasError as error:
        message, *_ = str(error).splitlines()
        return f'(cannot be read: {message})'
    if not _functions_of(tree) & _LISTED:
        return None
    return (ast.get_docstring(tree) or '').partition('\n')[0]


FUNCTIONS = Function.CONTROL, Function.CONDITION, Function.SI_TO_UNI
"""The functions that students fill in: a control law, a triggering condition, or si_to_uni."""

UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)
"""Errors of `ast.parse` for text that is not Python, or is nested too deeply."""


def exercise_of(script: Path) -> str:
    """Return the exercise that a script solves, '' if none; raise SetcmasError if unreadable.

    The script names it in a line such as exercise = 'consensus', or by its file name.
    """
    name = plain_values(script).get('exercise', script.stem)
    return name if isinstance(name, str) and name in EXERCISES else ''


def solution_of(exercise: str, function: Function) -> Path | None:
    """Return the solution that comes with an exercise; None if there is none.

    For a law, it is the built-in law of the same name; for a condition or si_to_uni, it is
    NAME_solution.py in the folder of the exercise.
    """
    if function is Function.CONTROL:
        return ALGORITHMS.file(exercise) if exercise in ALGORITHMS else None
    file = EXERCISES.file(exercise).with_name(f'{exercise}_solution.py')
    return file if file.is_file() else None


def is_unfilled(script: Path, exercise: str = '') -> bool:
    """Return whether a script's maths is still that of the empty exercise.

    Only these functions count, without comments and docstrings. Errors of a script that cannot
    be read are reported when it is loaded. The script names the exercise by default.
    """
    try:
        name = exercise or exercise_of(script)
        return bool(name) and same_functions(
            script.read_bytes(), EXERCISES.file(name).read_bytes()
        )
    except (OSError, SetcmasError):
        return False


def same_functions(source: bytes, exercise: bytes) -> bool:
    """Return whether a script has the functions of an empty exercise, unchanged."""
    try:
        return _functions(source) == _functions(exercise) != []
    except UNREADABLE:
        return False


def unfilled_note(script: Path) -> str:
    """Return a note that a script is not filled in yet; '' if it is."""
    if not is_unfilled(script):
        return ''
    name = exercise_of(script)
    if script == EXERCISES.file(name):
        copy = f'setcmas new my_{name} --from {name} --exercise'
        return f'exercise {name} is not filled in yet; copy it with {copy}'
    return f'{script.name} is not filled in yet; replace the parts marked TODO'


def _functions(source: bytes) -> list[str]:
    tree = ast.parse(source)
    nodes = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    names = [one.value for one in FUNCTIONS]
    functions = [node for node in nodes if node.name in names]
    for function in functions:
        if ast.get_docstring(function) is not None:
            del function.body[0]
    return [ast.dump(function) for function in functions]


class LawScripts:
    """The control script of each robot, and the values that `--set` gives to each script.

    Attributes:
        paths: The scripts, without repetition.
        settings: The values of each script.
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
        self.settings = self._shared_out(settings or {})
        for path in self.paths:
            compile_script(path, settings=self.settings[path])

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
        """Raise SetcmasError unless exactly the robots of the fleet but `others` have a script."""
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
