"""What task a run had, and the numbers of that task, read from the control script itself."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.scripts.loader import ALGORITHMS, find_script, load_script
from setcmas_ctrl.scripts.messages import describe_failure
from setcmas_ctrl.scripts.settings import Settings
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.files import kept_input

Floats = NDArray[np.float64]

TASKS = ('consensus', 'formation', 'distances', 'tracking', 'waypoints')

_BUILT_IN = {
    'consensus': 'consensus',
    'leader_follower_formation': 'formation',
    'leader_follower_distance_formation': 'distances',
    'traj_tracking': 'tracking',
    'nav_wp': 'waypoints',
}
_BUILT_IN_PATH = ('setcmas_ctrl', 'algorithms')


@dataclass(frozen=True)
class References:
    """What the robots were to reach; None for what is not part of the task.

    Attributes:
        task: One of TASKS.
        places: Places of robots 2, 3, ... beside the leader in m, shape (N - 1, 2).
        distance: Distance between robots in m.
        radius: Radius of the circular reference in m.
        rate: Angular rate along it in rad/s.
        waypoints: List of waypoints in m, shape (W, 2).
        reached: Distance in m at which a waypoint counts as reached.
    """

    task: str
    places: Floats | None = None
    distance: float | None = None
    radius: float | None = None
    rate: float | None = None
    waypoints: Floats | None = None
    reached: float | None = None


def script_of_run(source: Path, parameters: dict[str, Any], algo: str | None) -> Path | None:
    """Return the control script of a run, as it was in the run if that has kept it.

    Args:
        source: The fleet.csv of the run.
        parameters: Those of run.yaml. A built-in law is found by its name, wherever setcmas was
            installed on the machine of the run.
        algo: What `--algo` means, instead of run.yaml.

    Returns:
        The script, which may not exist any more; None if nothing tells of one.

    Raises:
        SetcmasError: There is no script `algo`.
    """
    if algo is not None:
        return find_script(algo)
    script = parameters.get('script') or parameters.get('algo')
    if not isinstance(script, str):
        return None
    *folders, name = re.split(r'[\\/]', script)
    stem = name.removesuffix('.py')
    stem = ALGORITHMS.file(stem).stem if stem in ALGORITHMS else stem
    if stem in _BUILT_IN and (not folders or tuple(folders[-2:]) == _BUILT_IN_PATH):
        return ALGORITHMS.file(stem)
    return kept_input(source, 'algo', name) or Path(script)


def task_of(script: Path | None) -> str | None:
    """Return the task of a built-in control law, None for other scripts."""
    is_built_in = (
        script is not None
        and script.resolve().parent == ALGORITHMS.file('nav_wp').parent.resolve()
    )
    return _BUILT_IN.get(script.stem) if script and is_built_in else None


def references(
    task: str, script: Path | None, nb_robots: int, settings: Settings | None = None
) -> References:
    """Return the references of a task, read from module-level names of a script.

    They are, named as in the built-in laws: PLACES, or places_of(followers) for any number of
    robots (formation); D (distances); R and W (tracking); WPL, and REACHED if it
    differs from that of nav_wp (waypoints; for the leader of a formation if WPL is there).

    Args:
        task: One of TASKS.
        script: The control script.
        nb_robots: Number of robots.
        settings: Values that took the place of the script's own in the run (`--set`).

    Raises:
        SetcmasError: The task is unknown, or the script is missing or does not define a number.
    """
    if task not in TASKS:
        raise SetcmasError(f"task '{task}' is unknown; accepted are {', '.join(TASKS)}")
    if task == 'consensus':
        return References(task)
    if script is None:
        raise SetcmasError(
            f"task '{task}' has numbers in the control script, which no run.yaml names; "
            'name it with --algo'
        )
    module = load_script(script, 0, settings=settings)
    if task == 'tracking':
        return References(task, radius=_number(module, 'R'), rate=_number(module, 'W'))
    points = reached = None
    if task == 'waypoints' or hasattr(module, 'WPL'):
        points, reached = _points('WPL', _value(module, 'WPL'), module), _reached(module)
    if task == 'formation':
        places = _places(module, nb_robots - 1)
        return References(task, places=places, waypoints=points, reached=reached)
    distance = _number(module, 'D') if task == 'distances' else None
    return References(task, distance=distance, waypoints=points, reached=reached)


def _places(module: ModuleType, number: int) -> Floats:
    if callable(getattr(module, 'places_of', None)):
        places = _points('places_of', _called(module, 'places_of', max(1, number)), module)
    else:
        places = _points('PLACES', _value(module, 'PLACES'), module)
    if len(places) < number:
        raise SetcmasError(
            f'{_name(module)}: there are {len(places)} places for {number} followers; '
            'accepted are PLACES with one for each, or places_of(followers)'
        )
    return places


def _called(module: ModuleType, name: str, argument: int) -> Any:
    try:
        return getattr(module, name)(argument)
    except Exception as error:  # of any kind, in a user's function
        raise SetcmasError(describe_failure(error, Path(str(module.__file__)))) from error


def _reached(module: ModuleType) -> float:
    if hasattr(module, 'REACHED'):
        return _number(module, 'REACHED')
    return _number(load_script(ALGORITHMS.file('nav_wp'), 0), 'REACHED')


def _number(module: ModuleType, name: str) -> float:
    value = _value(module, name)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise SetcmasError(f"{_name(module)}: {name} is '{value}'; accepted is a number")
    return number


def _points(name: str, value: Any, module: ModuleType) -> Floats:
    try:
        points = np.array(value, dtype=float)
    except (TypeError, ValueError):
        points = np.empty(0)
    is_list = points.ndim == 2 and points.shape[1] == 2 and len(points) > 0
    if not (is_list and np.isfinite(points).all()):
        raise SetcmasError(
            f"{_name(module)}: {name} is '{value}'; accepted are points [[x, y], ...]"
        )
    return points


def _value(module: ModuleType, name: str) -> Any:
    if not hasattr(module, name):
        raise SetcmasError(f'{_name(module)} defines no {name}, which its task needs')
    return getattr(module, name)


def _name(module: ModuleType) -> str:
    return Path(str(module.__file__)).name
