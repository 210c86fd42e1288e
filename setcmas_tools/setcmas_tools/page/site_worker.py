"""Runs, checks, plots and pages of runs in a web page: what its worker calls, in JSON texts.

The worker has numpy and PyYAML, and loads matplotlib when an answer says that it is needed. It
works in the current folder; scripts from the page are written there.
"""

from __future__ import annotations

import io
import json
import sys
import time
import zipfile
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import CodeType
from typing import Any

from setcmas_ctrl.laws.script_errors import summarise
from setcmas_ctrl.laws.script_settings import parse_setting
from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_rows
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.content import run_content
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunState, this_origin
from setcmas_tools.run.scenario import Scenario, options

Say = Callable[[str], object]
"""Takes a JSON text for the page, while a call works."""

Answer = dict[str, Any]

_SCRIPTS, _RUN = Path('own'), Path('run')
_LATER = ('matplotlib', 'PIL', 'mpl_toolkits')
_MOST_LETTERS = 200_000

_last: Run | None = None


def run_zip() -> bytes:
    """Return the folder of the last run, as `setcmas view` and others read it, as a zip file."""
    folder, content = _run_made().save(_RUN, overwrite=True), io.BytesIO()
    with zipfile.ZipFile(content, 'w', zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob('*')):
            archive.write(file, file.relative_to(folder.parent))
    return content.getvalue()


class _Page(io.TextIOBase):
    """Passes progress, warnings and what scripts print to the page."""

    def __init__(self, say: Say) -> None:
        self._say = say
        self._printed = ''
        self._letters = 0
        self.sent_at = time.perf_counter()

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
        self.sent_at = time.perf_counter()
        self._say(json.dumps(message))

    def end(self) -> None:
        """Pass on what has been printed."""
        if self._printed:
            self.send(print=self._printed)
            self._printed = ''

    def reached(self, t: float, of: float) -> None:
        """Show that a run has reached a time in s: the page names it if the next call hangs."""
        self.end()
        self.send(reached=t, of=of)


def _name_loops(page: _Page, limit_s: float | None) -> None:
    """Name the line of a script that loops, once nothing was sent to the page for `limit_s`.

    The page can end a loop, but it cannot see where it is.
    """
    if sys.version_info >= (3, 12):  # as in Pyodide
        monitoring, tool = sys.monitoring, sys.monitoring.DEBUGGER_ID
        folder = str(_SCRIPTS.absolute())

        def on_jump(code: CodeType, *_: int) -> object:
            if not code.co_filename.startswith(folder):
                return monitoring.DISABLE
            if limit_s and time.perf_counter() - page.sent_at > limit_s:
                line = sys._getframe(1).f_lineno
                page.send(loops=f'{Path(code.co_filename).name}, line {line}')
            return None

        if not monitoring.get_tool(tool):
            monitoring.use_tool_id(tool, 'setcmas')
        monitoring.register_callback(tool, monitoring.events.JUMP, on_jump)
        monitoring.set_events(tool, monitoring.events.JUMP)


def answer(call: str, request: str, say: Say = str) -> str:
    """Return the answer to a call of the page, or why there is none.

    Args:
        call: `run` a law: its run for the player, metrics and failures. `check` a law against an
            exercise: points, criteria with hints, a picture. `plots` of the last run.
            `report_html`: the page of the last run to hand in, with title and names.
        request: What the call is given.
        say: Takes what the page shows meanwhile.
    """
    calls = {'run': _simulated, 'check': _checked, 'plots': _plotted, 'report_html': _reported}
    page, asked = _Page(say), json.loads(request)
    _name_loops(page, asked.get('limit'))
    try:
        with redirect_stdout(page), redirect_stderr(page):
            found = {'ok': True, **calls[call](asked, page)}
    except SetcmasError as error:
        found = {'ok': False, 'error': str(error)}
    except ModuleNotFoundError as error:
        found = {'ok': False, 'error': str(error)}
        if str(error.name).partition('.')[0] in _LATER:
            found['needs'] = 'matplotlib'
    except BaseException as error:  # a script may have changed anything
        reason = f'the script has broken the simulation itself: {summarise(error)}'
        found = {'ok': False, 'error': reason, 'broken': True}
    page.end()
    return json.dumps(found, separators=(',', ':'), allow_nan=False)


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
    texts = [f'{name}={value}' for name, value in (asked.get('set') or {}).items()]
    settings = dict(map(parse_setting, texts))
    law = asked.get('algo') or 'consensus'
    if asked.get('script') is not None:
        script = str(_written(asked))
        if asked.get('function') == 'ctc':
            values |= {'ctc': script, 'event_triggered': True}
        elif asked.get('function') == 'si_to_uni':
            values['si_to_uni'] = script
        else:
            law = script
    return Scenario.of(law, **values, set=settings)


def _value(name: str, value: Any) -> Any:
    """Return the value of an option; texts are read as on the command line."""
    is_typed = isinstance(value, str) and name in options()
    return options()[name].kind.value(value) if is_typed else value


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
        parts: Mapping[str, Any] = measure(made, page.warn)
    except SetcmasError as error:
        return {'headers': [], 'rows': [], 'lines': [str(error)]}
    headers, *rows = robots_rows(parts) or [[]]
    return {'headers': headers, 'rows': rows, 'lines': fleet_lines(parts)}


def _checked(asked: Answer, page: _Page) -> Answer:
    from setcmas_tools.grade.check import Check, marks_of, runs_here
    from setcmas_tools.grade.rubric import chosen_rubric

    script, given = _written(asked), asked.get('rubric')
    file = next(Path('rubrics', given).glob(f'{given}.y*ml')) if given else None
    rubric = chosen_rubric(script, file or asked.get('exercise')).shown()
    run_one = runs_here(str(script), rubric.function)

    def run_shown(scenario: Any) -> Any:
        page.send(scenario=scenario.name)
        return run_one(scenario)

    found = Check(marks_of(script, rubric, run_shown))
    return {**found.plain(), 'picture': found.picture_url()}


def _plotted(_: Answer, page: _Page) -> Answer:
    from setcmas_tools.page.report_file import plot_pictures

    return {'plots': [*plot_pictures(_run_made(), page.warn)]}


def _reported(asked: Answer, page: _Page) -> Answer:
    from setcmas_tools.page.report_file import report_page

    run = _run_made()
    made_here = replace(run, info=replace(run.info, origin=this_origin()))
    return {'html': report_page(made_here, 'run', page.warn, asked['title'], asked['name'])}


def _run_made() -> Run:
    if _last is None:
        raise SetcmasError('there is no run yet; press Run')
    return _last
