"""Handout of a rubric: its visible part for students, with the solution's runs instead of it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from setcmas_ctrl.laws.script_imports import with_helpers
from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_ctrl.laws.script_search import FUNCTIONS, solution_of
from setcmas_simu.errors import SetcmasError
from setcmas_simu.yaml_entries import Entry, read_entries
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.run.run_tables import RunTables, write_tables
from setcmas_tools.run.scenario_files import named_in

_KEPT = ('title', 'exercise', 'function')
_HEAD = """\
# The visible part of a rubric, made by `setcmas grade --handout`. The paths of the solution are
# in the folder references. To check a law: setcmas check LAW --rubric {name}
"""
_LONG_AGO = (1980, 1, 1, 0, 0, 0)  # earliest time in a zip file


def handout(rubric: Rubric) -> dict[str, bytes]:
    """Return the files that students need to check their laws by a rubric, by path.

    It has no hidden criteria or scenarios, and neither the source of the solution nor what the
    rubric says about it; only the runs of the solution in the visible scenarios.

    Raises:
        SetcmasError: The solution fails or cannot be left out, no part of the rubric is visible,
            or a file is outside the rubric's folder.
    """
    shown = rubric.shown()
    if not shown.scenarios:
        raise SetcmasError(f"all of '{rubric.file}' is hidden; students can check nothing")
    is_public = rubric.solution is None or _ships(rubric.solution)
    own = [file for scenario in shown.scenarios for file in scenario.files]
    folder = rubric.file.parent
    for file in own:
        named_in(folder, rubric.file.name, str(file))  # raises for those elsewhere
    files = [one.resolve() for file in own for one in with_helpers(file)]
    if not is_public and rubric.solution in files:
        raise SetcmasError(f"a visible scenario needs the solution '{rubric.solution}' as a file")
    if not is_public and shown.compares_answers:
        raise SetcmasError(
            'answer_error and direction_error need the solution itself; use path_error, or hide it'
        )
    text = _text(rubric, shown, is_public).encode()
    references = {} if is_public else _references(shown)
    # All other files are laws of packages, which students have, too.
    inside = [file for file in files if file.is_relative_to(folder)]
    named = {file.relative_to(folder).as_posix(): file.read_bytes() for file in inside}
    return {**named, **references, rubric.file.name: text}


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return a zip archive of files by path; the same files make the same bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, 'w') as target:
        for path, data in files.items():
            info = zipfile.ZipInfo(path, _LONG_AGO)
            info.external_attr = 0o100644 << 16
            info.create_system = 3  # Unix, to keep modes
            target.writestr(info, data, zipfile.ZIP_DEFLATED)
    return content.getvalue()


def _ships(solution: Path) -> bool:
    """Return whether a script comes with setcmas, which students have, too."""
    laws = (ALGORITHMS.file(name) for name, one in ALGORITHMS.plugins().items() if one.built_in)
    exercises = (name for name, one in EXERCISES.plugins().items() if one.built_in)
    others = (solution_of(name, function) for name in exercises for function in FUNCTIONS)
    return solution in (*laws, *others)


def _references(shown: Rubric) -> dict[str, bytes]:
    """Return the tables of the solution's runs by path: references/NUMBER/TABLE."""
    files = {}
    for number, scenario in enumerate(shown.scenarios, start=1):
        run = shown.solution_run(scenario)
        assert run
        tables = RunTables(run.table, run.commands, run.record, references=run.references)
        with TemporaryDirectory() as folder:
            write_tables(tables, Path(folder))
            for path in sorted(Path(folder).iterdir()):
                files[f'references/{number}/{path.name}'] = path.read_bytes()
    return files


def _text(rubric: Rubric, shown: Rubric, is_public: bool) -> str:
    fields = read_entries(rubric.file).value
    content = {key: _plain(fields[key]) for key in _KEPT if key in fields}
    content['function'] = rubric.function.value
    if is_public:  # it also comes with setcmas
        public = ('solution', 'mistakes')
        content |= {key: _plain(fields[key]) for key in public if key in fields}
    else:
        content['references'] = {
            scenario.name: f'references/{number}'
            for number, scenario in enumerate(shown.scenarios, start=1)
        }
    if shown.hidden_points:
        content['hidden_points'] = shown.hidden_points
    scenarios = [_shown(one) for one in fields['scenarios'].items() if not _is_hidden(one)]
    content['scenarios'] = [one for one in scenarios if one['criteria']]
    text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=100)
    return _HEAD.format(name=rubric.file.name) + text


def _shown(scenario: Entry) -> dict[str, Any]:
    """Return a scenario without its hidden criteria, and without needs of these."""
    visible = [one for one in scenario.value['criteria'].items() if not _is_hidden(one)]
    criteria = [_plain(one) for one in visible]
    names = {one.get('name') for one in criteria}
    for one in criteria:
        if one.get('needs') not in names:
            one.pop('needs', None)
    return {**_plain(scenario), 'criteria': criteria}


def _is_hidden(entry: Entry) -> bool:
    return 'hidden' in entry.value and entry.value['hidden'].flag()


def _plain(entry: Entry) -> Any:
    """Return the value as it is written; `Entry.plain` turns the text 1e-3 into a number."""
    if isinstance(entry.value, dict):
        return {key: _plain(one) for key, one in entry.value.items()}
    if isinstance(entry.value, list):
        return [_plain(one) for one in entry.value]
    return entry.value
