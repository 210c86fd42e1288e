"""Catalogue of a web page: the laws, exercises, scenarios and options that it offers."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import Field, fields
from importlib import resources
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES, names_to_set
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import Option, default_of, plain
from setcmas_simu.option_kinds import Number, Whole
from setcmas_simu.plugins import ScriptGroup
from setcmas_simu.robots.models_by_name import MODELS
from setcmas_tools.grade.rubric import Rubric, read_rubric, rubric_of_exercise
from setcmas_tools.run.scenario import Scenario

_OFFERED = (
    'nb_robots', 'duration', 'graph', 'range', 'delay', 'loss', 'noise', 'event_triggered',
    'threshold', 'own_state', 'model', 'limits', 'vnom', 'komega', 'rate', 'robot_rate', 'seed',
    'random_poses', 'pose', 'arena', 'obstacles',
)  # fmt: skip
"""Options of the page, in order; the others need ROS, a solver, or files."""

_COMMANDS = re.compile(r'\nCommands\n(    .*\n)+"""')
"""The end of an exercise's docstring: a page has no terminal to type them in."""


def catalogue(
    names: Sequence[str] = (), rubrics: Sequence[Path] = (), scenarios: Sequence[Path] = ()
) -> dict[str, Any]:
    """Return what a page offers, and with what it begins, as JSON has it.

    Args:
        names: Exercises; all shipped ones, and the laws that solve them, without names and
            rubrics.
        rubrics: Rubrics; only their shown parts are described.
        scenarios: Scenario files.

    Raises:
        SetcmasError: An exercise is unknown, or a file has a mistake or the name of another.
    """
    for files in (rubrics, scenarios):
        stems = [one.stem for one in files]
        if twice := sorted({one for one in stems if stems.count(one) > 1}):
            raise SetcmasError(f"two files are named '{twice[0]}'; rename one")
    chosen = names or (() if rubrics else _exercises_with_rubrics())
    exercises = [
        {**_law(name, EXERCISES.file(name)), **_rubric(name, rubric_of_exercise(name))}
        for name in chosen
    ]
    of_files = [_rubric(one.stem, read_rubric(one)) for one in rubrics]
    solved = {*names, *(one['exercise'] for one in of_files)}
    template = resources.files('setcmas_ctrl') / 'templates' / 'control_law.py'
    begins = [
        *(f'exercise:{name}' for name in names),
        *(f'rubric:{one.stem}' for one in rubrics),
        *(f'scenario:{one.stem}' for one in scenarios),
        'law:consensus',
    ]
    return {
        'first': begins[0],
        'laws': [
            _law(name, ALGORITHMS.file(name)) for name in _names(ALGORITHMS) if name not in solved
        ],
        'exercises': exercises,
        'rubrics': of_files,
        'template': {'name': 'my_law.py', 'text': template.read_text(encoding='utf-8')},
        'scenarios': [_scenario(one) for one in scenarios],
        'options': _options(),
    }


def _exercises_with_rubrics() -> list[str]:
    names = _names(EXERCISES)
    return [name for name in names if EXERCISES.file(name).with_suffix('.yaml').is_file()]


def _names(group: ScriptGroup) -> list[str]:
    """Return the names of the scripts of a group, one for each script."""
    names: dict[Path, str] = {}
    for name in group.plugins():
        names.setdefault(group.file(name), name)
    return [*names.values()]


def _law(name: str, file: Path) -> dict[str, Any]:
    return {
        'name': name,
        'text': _COMMANDS.sub('"""', file.read_text(encoding='utf-8'), count=1),
        'settings': [one for one in names_to_set(file) if one.isupper()],  # others are state
    }


def _rubric(name: str, rubric: Rubric) -> dict[str, Any]:
    shown = rubric.shown()
    return {
        'name': name,
        'title': shown.title,
        'exercise': shown.exercise,
        'function': shown.function.value,
        'points': shown.max_score,
    }


def _scenario(file: Path) -> dict[str, Any]:
    scenario = Scenario.load(file)
    values = {k: plain(v) for k, v in scenario.changed().items() if k != 'algo'}
    own = [one for one in scenario.scripts() if one == Path(str(scenario.law.algo))]
    script = {'name': own[0].name, 'text': own[0].read_text(encoding='utf-8')} if own else None
    law = Path(str(scenario.law.algo)).stem
    return {'name': file.stem, 'values': values, 'algo': law, 'script': script}


def _options() -> list[dict[str, Any]]:
    found = {one.name: one for kind in Scenario.PARTS.values() for one in fields(kind)}
    return [_option(found[name]) for name in _OFFERED]


def _option(one: Field[Any]) -> dict[str, Any]:
    option: Option = one.metadata['option']
    kind = option.kind
    default = plain(default_of(one))
    return {
        'name': one.name,
        'help': option.help,
        'must_be': kind.must_be,
        'input': _input(option),
        'default': None if default == math.inf else default,  # as JSON has no limit
        'default_text': option.default_text,
        'unit': getattr(kind, 'unit', ''),
        'choices': [*(MODELS.plugins() if one.name == 'model' else kind.choices)],
    }


def _input(option: Option) -> str:
    if option.is_switch:
        return 'switch'
    if option.is_several:
        return 'several'
    if isinstance(option.kind, Number):
        return 'number'
    if isinstance(option.kind, Whole):
        return 'whole'
    return 'choice' if option.kind.choices else 'text'
