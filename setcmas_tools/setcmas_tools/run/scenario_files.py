"""Files that a scenario names, by paths from the folder of its own file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from setcmas_ctrl.communication.triggering_conditions import CTC
from setcmas_ctrl.laws.control_options import SI_TO_UNI
from setcmas_ctrl.laws.script_function import CONTROL
from setcmas_ctrl.laws.script_loader import ALGORITHMS, CONDITIONS, EXERCISES
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import is_per_robot, parse_per_robot
from setcmas_simu.robots.models_by_name import is_file

OF_FILES = ('algo', 'si_to_uni', 'ctc', 'graph', 'model', 'poses', 'lab')
"""The values of a scenario that may name files."""

_SCRIPTS = {
    'algo': (ALGORITHMS, CONTROL),
    'ctc': (CONDITIONS, CTC),
    'si_to_uni': (None, SI_TO_UNI),
}
"""The scripts that ship, and the function that a script must define, by the name of a value."""

INPUTS = 'inputs'
"""The folder of a run with copies of the files that its scenario names."""


def placed_in(folder: Path, name: str, text: str, exercise: bool = False) -> str:
    """Return the absolute path of the file in the text of a value, or raise SetcmasError.

    Args:
        folder: That of the scenario's file, to which the paths in it are relative.
        name: Name of the value.
        text: A path, or the name of a script that ships.
        exercise: Whether laws may be exercises.
    """
    if name == 'model' and not (is_file(text) or _is_path(text)):
        return text
    path = (folder / text).resolve()
    if path.is_file():
        return str(path)
    if name not in _SCRIPTS or _is_path(text):
        raise SetcmasError(f"there is no file '{text}' in '{folder.resolve()}'")
    if exercise and text in EXERCISES:
        return str(EXERCISES.file(text))
    shipped, function = _SCRIPTS[name]
    if shipped and (name == 'algo' or text in shipped):
        return str(shipped.file(text))
    raise SetcmasError(
        f"script '{text}' of {name} was not found; it must be a script in the scenario's "
        f'folder with a function {function}'
    )


def named_in(folder: Path, name: str, text: str) -> str:
    """Return the text of a value in a file in a folder, for a path, or raise SetcmasError."""
    path = Path(text)
    if built_in := built_in_name(path):
        return built_in
    if not path.is_file():
        return text
    inside = folder.resolve()
    if not path.resolve().is_relative_to(inside):
        raise SetcmasError(f"{name} names '{text}', which is outside '{inside}'; copy it there")
    return path.resolve().relative_to(inside).as_posix()


def _is_path(text: str) -> bool:
    return text.endswith('.py') or '/' in text or '\\' in text


def built_in_name(path: Path) -> str:
    """Return the name of a script of setcmas or a plugin; empty for other paths."""
    for group in (ALGORITHMS, EXERCISES, CONDITIONS):
        if path.is_absolute() and path.stem in group and group.file(path.stem) == path:
            return path.stem
    return ''


def robots_by_text(value: Any) -> dict[str, list[int]]:
    """Return each text of a value, with its robots; no robots means all."""
    if isinstance(value, str) and is_per_robot(value):
        value = parse_per_robot(value, 'it')
    if not isinstance(value, Mapping):
        return {str(value): []} if isinstance(value, (str, Path)) else {}
    robots_of: dict[str, list[int]] = {}
    for robot, text in value.items():
        if isinstance(text, str):
            robots_of.setdefault(text, []).append(robot)
    return robots_of
