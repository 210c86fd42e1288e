"""Runs, checks, plots and pages of runs in a web page: what its worker calls, in JSON texts.

The worker has numpy and PyYAML, and loads matplotlib when an answer says that it is needed. It
works in the current folder; scripts from the page are written there.
"""

from __future__ import annotations

import io
import json
import re
import time
import zipfile
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_errors import (
    described_place,
    quoted_line,
    script_place,
    summarise,
)
from setcmas_ctrl.laws.script_settings import parse_setting
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_rows
from setcmas_tools.offline import run_progress
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.offline.run_progress import LateCallError, limited_calls
from setcmas_tools.page.content import run_content
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import OfflineOptions
from setcmas_tools.run.run_info import RunState, this_origin
from setcmas_tools.run.scenario import Scenario, options

Say = Callable[[str], object]
"""Takes a JSON text for the page, while a call works."""

Answer = dict[str, Any]

SCENARIOS, RUBRICS = 'scenarios', 'rubrics'
"""Folders with the scenario files and rubrics of the page, a folder or a file for each name."""

_SCRIPTS, _RUN = Path('own'), Path('run')
_PLACE = re.compile(r'(\w+\.py), line (\d+)')
_LATER = ('matplotlib', 'PIL', 'mpl_toolkits')
_MOST_LETTERS = 200_000
_SAY_S = 0.1

_last: Run | None = None


def run(request: str, say: Say) -> str:
    """Run a law; return the content of the page's player, metrics and failures."""
    return _answered(_simulated, request, say)


def check(request: str, say: Say) -> str:
    """Check a law against an exercise; return points, criteria with hints, and the picture."""
    return _answered(_checked, request, say)


def plots(request: str = '{}', say: Say = str) -> str:
    """Return the plots of the last run."""
    return _answered(_plotted, request, say)


def report_html(request: str, say: Say = str) -> str:
    """Return the page of the last run to hand in, with title and names."""
    return _answered(_reported, request, say)


def run_zip() -> bytes:
    """Return the folder of the last run, as `setcmas view` and others read it, as a zip file."""
    folder, content = _run_made().save(_RUN, overwrite=True), io.BytesIO()
    with zipfile.ZipFile(content, 'w', zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob('*')):
            archive.write(file, file.relative_to(folder.parent))
    return content.getvalue()


class _Page(io.TextIOBase):
    """Passes progress, warnings and what scripts print to the page, a few times a second."""

    def __init__(self, say: Say) -> None:
        self._say = say
        self._printed = ''
        self._letters = 0
        self._next = 0.0

    def write(self, text: str) -> int:
        """Print a text; what exceeds a limit is not shown."""
        if self._letters <= _MOST_LETTERS:
            self._letters += len(text)
            more = self._letters > _MOST_LETTERS
            self._printed += '\n... the script prints more, which is not shown\n' if more else text
        return len(text)

    def warn(self, message: str) -> None:
        """Show a message."""
        self.end()
        self.send(warn=message)

    def send(self, **message: Any) -> None:
        """Pass a message on."""
        self._say(json.dumps(message))

    def end(self) -> None:
        """Pass on what has been printed."""
        if self._printed:
            self.send(print=self._printed)
            self._printed = ''

    def reached(self, t: float, of: float) -> None:
        """Show that a run has reached a time in s, but not too often."""
        if time.perf_counter() > self._next:
            self._next = time.perf_counter() + _SAY_S
            self.end()
            self.send(reached=t, of=of)

    def alive(self) -> None:
        """Show that scripts run."""
        self.end()
        self.send(alive=True)


def _answered(work: Callable[[Answer, _Page], Answer], request: str, say: Say) -> str:
    """Return the answer of some work, or why there is none, as JSON."""
    page, asked = _Page(say), json.loads(request)
    limit = float(asked.get('call_timeout') or OfflineOptions().call_timeout)
    try:
        with redirect_stdout(page), redirect_stderr(page), limited_calls(limit, page.alive):
            answer = {'ok': True, **work(asked, page)}
    except SetcmasError as error:
        answer = _refusal(str(error))
    except LateCallError as error:
        answer = {**_refusal(_late(error, limit)), 'late': True}
    except ModuleNotFoundError as error:
        answer = _refusal(str(error))
        if str(error.name).partition('.')[0] in _LATER:
            answer['needs'] = 'matplotlib'
    except BaseException as error:  # a script may have changed anything
        reason = f'the script has broken the simulation itself: {summarise(error)}'
        answer = {**_refusal(reason), 'broken': True}
    page.end()
    return json.dumps(answer, separators=(',', ':'), allow_nan=False)


def _refusal(message: str) -> Answer:
    return {'ok': False, 'error': message, **_place_in(message)}


def _place_in(message: str) -> Answer:
    """Return file and line of the script that a message names."""
    found = _PLACE.search(message)
    return {'file': found[1] if found else '', 'line': int(found[2]) if found else 0}


def _late(error: LateCallError, limit: float) -> str:
    """Return the message on a call that took longer than a limit in s."""
    file, line = script_place(error, Path())
    call = run_progress.current.call.last()  # the error may have ended it
    assert call
    what, place = call.function.late(file.name, limit), described_place(file, line, file)
    return f'{robot_name(call.robot)}: {what}; it is at {place}{quoted_line(file, line)}'


def _simulated(asked: Answer, page: _Page) -> Answer:
    global _last
    _last = None
    scenario = _scenario(asked)
    scenario.check()
    for note in (*scenario.notes_on_simulation, *scenario.safety.notes):
        page.warn(note)
    duration = scenario.time.duration
    begin = time.perf_counter()
    _last = made = simulate(scenario, warn=page.warn, progress=partial(page.reached, of=duration))
    seconds = time.perf_counter() - begin
    return {
        'page': run_content(made),
        'title': made.title,
        'links': made.record is not None,
        'outcome': str(made.outcome).partition('\n')[0],
        'well': made.outcome.state is RunState.COMPLETE,
        'failures': _failures(made),
        'metrics': _metrics(made, page),
        'seconds': seconds,
    }


def _scenario(asked: Answer) -> Scenario:
    """Return the scenario of a request, or raise SetcmasError if a value is invalid."""
    given = asked.get('scenario') or {}
    values = {
        name: _value(name, value) for name, value in given.items() if value not in (None, '')
    }
    settings = dict(_setting(*pair) for pair in (asked.get('set') or {}).items())
    law, file = asked.get('algo'), asked.get('scenario_file')
    if asked.get('script') is not None:
        script = str(_written(asked))
        if asked.get('function') == 'ctc':
            values |= {'ctc': script, 'event_triggered': True}
        elif asked.get('function') == 'si_to_uni':
            values['si_to_uni'] = script
        else:
            law = script
    if file:
        base = Scenario.load(_file_of(SCENARIOS, file))
        own = {'set': {**base.law.set, **settings}} if settings else {}
        return base.replace(**values, **own, **({'algo': law} if law else {}))
    return Scenario.of(law or 'consensus', **values, set=settings)


def _value(name: str, value: Any) -> Any:
    """Return the value of an option; texts are read as on the command line."""
    is_typed = isinstance(value, str) and name in options()
    return options()[name].kind.parse(value) if is_typed else value


def _setting(name: str, value: Any) -> tuple[str, Any]:
    return parse_setting(f'{name}={value}') if isinstance(value, str) else (name, value)


def _file_of(folder: str, name: str) -> Path:
    """Return the YAML file NAME.yaml, or that in the folder NAME, or raise SetcmasError."""
    places = Path(folder), Path(folder, Path(name).name)
    named = [file for one in places for file in one.glob(f'{Path(name).name}.yaml')]
    found = [*named, *sorted(places[1].glob('*.yaml'))]
    if not found:
        raise SetcmasError(f"this page has no {folder.removesuffix('s')} '{name}'")
    return found[0]


def _written(asked: Answer) -> Path:
    """Write the script of a request, or raise SetcmasError; return its file."""
    name = str(asked.get('name') or 'my_law.py')
    if not (name.endswith('.py') and name.removesuffix('.py').isidentifier()):
        raise SetcmasError(
            f"'{name}' cannot be the name of a script; use letters, digits and _, such as "
            'my_law.py'
        )
    _SCRIPTS.mkdir(exist_ok=True)
    path = (_SCRIPTS / name).absolute()
    path.write_text(asked['script'], encoding='utf-8', errors='replace')
    return path


def _failures(made: Run) -> list[Answer]:
    """Return the first failure at each line."""
    first: dict[tuple[str, int | None], Answer] = {}
    for one in made.info.failures or []:
        entry = {'robot': one.robot, 't': one.t, 'file': one.script, 'line': one.line or 0}
        first.setdefault((one.script, one.line), {**entry, 'text': one.text})
    return [*first.values()]


def _metrics(made: Run, page: _Page) -> Answer:
    try:
        parts: Mapping[str, Any] = measure(made, page.warn).parts
    except SetcmasError as error:
        return {'headers': [], 'rows': [], 'lines': [str(error)]}
    headers, *rows = robots_rows(parts) or [[]]
    return {'headers': headers, 'rows': rows, 'lines': fleet_lines(parts)}


def _checked(asked: Answer, page: _Page) -> Answer:
    from setcmas_tools.grade.check import Check, OwnLaw, runs_here
    from setcmas_tools.grade.rubric import chosen_rubric

    script = _written(asked)
    own, name = OwnLaw.of(script), asked.get('rubric')
    rubric = chosen_rubric(script, _file_of(RUBRICS, name) if name else asked.get('exercise'))
    rubric = rubric.shown()
    run_one = runs_here(str(script), rubric.function)

    def run_shown(scenario: Any) -> Any:
        page.send(scenario=scenario.name)
        return run_one(scenario)

    found = Check(own.marks(rubric, run_shown))
    marks = found.marks
    scenarios = [_scenario_entry(one) for one in marks.scenarios]
    hints = [c['hint'] for one in scenarios for c in one['criteria'] if c['hint']]
    return {
        'title': marks.title,
        'points': marks.score,
        'of': marks.max_score,
        'full': marks.is_full,
        'unfilled': marks.unfilled,
        'hint': hints[0] if hints else '',
        'scenarios': scenarios,
        'picture': found.picture_url() if any(one.paths for one in marks.scenarios) else '',
    }


def _scenario_entry(mark: Any) -> Answer:
    message = mark.failure.message if mark.failure else ''
    criteria = [
        {
            'name': one.name,
            'points': one.points,
            'of': one.max_points,
            'full': one.is_full,
            'reached': one.reached_text,
            'wanted': one.wanted,
            'hint': one.hint,
        }
        for one in mark.criteria
    ]
    entry = {'name': mark.name, 'points': mark.points_text, 'failure': message}
    return {**entry, **_place_in(message), 'criteria': criteria}


def _plotted(_: Answer, page: _Page) -> Answer:
    from setcmas_tools.page.report_file import Pair, plot_pictures

    pair = Pair('run', _run_made(), warn=page.warn)
    pictures = plot_pictures(pair)
    return {'plots': [{'name': p.name, 'picture': p.url, 'share': p.share} for p in pictures]}


def _reported(asked: Answer, page: _Page) -> Answer:
    from setcmas_tools.page.report_file import Cover, Pair, report_page

    cover = Cover(asked.get('title') or '', asked.get('name') or '', None)
    run = _run_made()
    made_here = replace(run, info=replace(run.info, origin=this_origin()))
    return {'html': report_page(Pair('run', made_here, warn=page.warn), cover)}


def _run_made() -> Run:
    if _last is None:
        raise SetcmasError('there is no run yet; press Run')
    return _last
