"""The page of a run as one file to hand in.

Answers of students, written in Markdown, become HTML that only shows: no scripts, no network.
"""

from __future__ import annotations

import io
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from string import Template
from typing import Any

from matplotlib.figure import Figure
from PIL import Image

from setcmas_simu.errors import SetcmasError, file_errors, needs
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.limited_file import written_whole
from setcmas_simu.script_calls import ScriptFailure
from setcmas_tools.measures.comparison import flat
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_table
from setcmas_tools.page.content import run_content
from setcmas_tools.page.document import document, element, escaped, template
from setcmas_tools.plots.plot import drawn_plots
from setcmas_tools.plots.style import data_url, plot_style, png
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import find_run
from setcmas_tools.run.run_info import RunState

_ENDINGS = ('.html', '.htm')


def check_page(page: Path, overwrite: bool = False) -> None:
    """Check that a page can be written to a file; raise SetcmasError otherwise."""
    if page.suffix.lower() not in _ENDINGS:
        raise SetcmasError(f"the page '{page}' must end with .html")
    if not page.parent.is_dir():
        raise SetcmasError(
            f"the page '{page}' cannot be written: there is no folder '{page.parent}'; create it"
        )
    if page.exists() and not overwrite:
        raise SetcmasError(f"'{page}' exists; --overwrite replaces it")


def write_page(page: Path, text: str) -> None:
    """Write a page, or raise SetcmasError."""
    with file_errors(f"'{page}' cannot be written"), written_whole(page) as file:
        file.write(text.encode(errors='replace').decode())


def run_name(path: Path) -> str:
    """Return the name of a run's folder or recording, or raise SetcmasError."""
    source = find_run(path)
    return source.stem.rstrip('_') or source.folder.resolve().name or 'run'


def report_page(
    run: Run,
    name: str,
    warn: Callable[[str], None] = print,
    own_title: str = '',
    names: str = '',
    answers: Path | None = None,
) -> str:
    """Return the page of a run with a name.

    Args:
        run: The run.
        name: That of its folder or recording.
        warn: Shows metrics and plots that fail.
        own_title: Replaces the title of the run.
        names: Who hands it in.
        answers: A file with their answers, in Markdown.

    Raises:
        SetcmasError: The answers cannot be read.
    """
    info, title = run.info, own_title or run.title
    duration = float(run.table.t[-1]) - max(0.0, float(run.table.t[0]))
    start = (info.started or '')[:19].replace('T', ' ')
    when = f'{round(duration, 1):g} s' + (f', started {start}' if start else '')
    table, remarks = _metrics(run, warn)
    made: dict[str, object] = {'seed': info.seed}
    if origin := info.origin:
        made |= {'setcmas': origin.setcmas, **origin.versions, **origin.host}
        made['computer'] = made.pop('name', '')
    given = {k: v for k, v in flat(info.parameters).items() if v not in (None, [])}
    body = Template(template('report.html')).substitute(
        name=escaped(name),
        title=escaped(title),
        names=escaped(names),
        when=escaped(f'{run.title}, {when}' if own_title else when),
        quality='good' if run.outcome.state is RunState.COMPLETE else 'bad',
        outcome=escaped(str(run.outcome).partition('\n')[0]),
        answers=answers_html(answers) if answers else '',
        failures=''.join(_failures(run)),
        stage=template('stage.html'),
        metrics=table,
        remarks='\n'.join(element('p', remark) for remark in remarks),
        plots='\n'.join(map(_image, plot_pictures(run, warn))),
        listings='\n'.join(listings(run)),
        command=escaped(shlex.join(info.command or [])),
        made=_terms(made),
        options=_terms(given),
    )
    return document(title, body, run_content(run))


def answers_html(file: Path) -> str:
    """Return the HTML of a Markdown file; HTML and formulas are shown as text, images as links.

    Raises:
        SetcmasError: The file cannot be read, or a package is missing.
    """
    with needs('report'):
        from markdown_it import MarkdownIt

    markdown = MarkdownIt('commonmark', {'html': False}).enable(['table', 'strikethrough'])
    tokens = markdown.disable('image').parse(_text(file))
    for token in tokens:
        if token.type in ('heading_open', 'heading_close'):  # below the title of the page
            token.tag = f'h{min(6, int(token.tag[1:]) + 1)}'
    return str(markdown.renderer.render(tokens, markdown.options, {}))


def _text(file: Path) -> str:
    try:
        with file_errors(f"answers '{file}' cannot be read"):
            return file.read_text(encoding='utf-8-sig')
    except UnicodeDecodeError as error:
        raise SetcmasError(f"answers '{file}' must be a text file in UTF-8") from error


def failures_alike(failures: Iterable[ScriptFailure]) -> list[list[ScriptFailure]]:
    """Return failures sorted by time, those of robots that failed alike together."""
    alike: dict[tuple[str, int | None, str], list[ScriptFailure]] = {}
    for one in sorted(failures, key=lambda one: one.t):
        kind = one.first_line.partition(':')[0]  # what follows may have numbers in it
        alike.setdefault((one.script, one.line, kind), []).append(one)
    return [*alike.values()]


def _failures(run: Run) -> Iterator[str]:
    alike = failures_alike(run.info.failures or [])
    for ones in alike:
        first = ones[0]
        place = f'{first.script}, line {first.line}' if first.line else first.script
        yield f'<p>{failure_html(ones)} {element("span", f"({place})", "soft")}</p>'
    detail = run.outcome.detail
    if not alike and detail not in str(run.outcome).partition('\n')[0]:
        yield element('p', detail)


def failure_html(ones: list[ScriptFailure]) -> str:
    """Return failures that are alike, with a button that shows the time of the first."""
    first, ends = ones[0], [one.until for one in ones]
    robots = robots_in_words(sorted({one.robot for one in ones}))
    times = len([one for one in ones if one.robot == first.robot])
    until = 'to the end' if None in ends else f'to {max(end or 0.0 for end in ends):.1f} s'
    again = f', {times} times' if times > 1 else ''
    when = f'{robots}, t = {first.t:.1f} s {until}{again}'
    button = f'<button class="time" data-t="{first.t:g}" data-robot="{first.robot}">'
    return f'{button}{escaped(when)}</button> {escaped(first.first_line)}'


def _metrics(run: Run, warn: Callable[[str], None]) -> tuple[str, list[str]]:
    try:
        parts = measure(run, warn)
        return robots_table(parts, 'html'), fleet_lines(parts)
    except SetcmasError as error:
        return '', [str(error)]


_WIDEST_IN = 9.0
_DPI = 110
_COLOURS = 128
"""Enough for lines and letters with smooth edges."""


def plot_pictures(run: Run, warn: Callable[[str], None]) -> Iterator[dict[str, Any]]:
    """Yield name and data URL of each plot, and its share of the page's width.

    The share gives all plots letters of the same size.
    """
    with plot_style():
        for name, figure in drawn_plots(run, warn):
            share = round(min(1.0, figure.get_figwidth() / _WIDEST_IN), 2)
            yield {'name': name, 'url': data_url('image/png', _png(figure)), 'share': share}


def _png(figure: Figure) -> bytes:
    small = io.BytesIO()
    picture = Image.open(io.BytesIO(png(figure, _DPI))).convert('RGB')
    picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(small, format='png', optimize=True)
    return small.getvalue()


def _image(plot: Mapping[str, Any]) -> str:
    name, share = escaped(plot['name']), plot['share']
    return f'<img src="{plot["url"]}" alt="{name}" style="--share: {share}">'


_OPTIONS = {
    'algo': 'control law',
    'si_to_uni': 'si_to_uni',
    'ctc': 'triggering condition',
    'model': 'robot model',
}


def listings(run: Run) -> Iterator[str]:
    """Yield the scripts of a run as HTML, laws first, each with its modules."""
    for option, role in _OPTIONS.items():
        for given in (one for one in run.inputs if one.option == option):
            robots = f' of {robots_in_words(list(given.robots))}' if given.robots else ''
            for file, content in zip(given.files, given.contents, strict=True):
                what = role if file == given.path else f'module of {given.path.name}'
                failures = [
                    one
                    for one in run.info.failures or []
                    if one.script == file.name and (not given.robots or one.robot in given.robots)
                ]
                yield _listing(file.name, what + robots, content, failures)


def _listing(name: str, what: str, content: bytes, failures: list[ScriptFailure]) -> str:
    """Return a script as HTML; a click on a line that failed shows when it first did."""
    shown = []
    for number, line in enumerate(content.decode(errors='replace').splitlines() or [''], 1):
        # `--watch` loads other versions: a failure is shown at the line that it quotes.
        here = [one for one in failures if one.line == number and line.strip() in one.text]
        first = min(here, key=lambda one: one.t, default=None)
        at = f' class="at" data-t="{first.t:g}" data-robot="{first.robot}"' if first else ''
        shown.append(f'<span{at}><i>{number}</i> {escaped(line)}</span>')
    head = f'<h2>{escaped(name)} {element("span", what, "soft")}</h2>'
    return f'<section class="listing">\n{head}\n<pre>{"".join(shown)}</pre>\n</section>'


def _terms(entries: Mapping[str, object]) -> str:
    lines = (element('dt', name) + element('dd', value) for name, value in entries.items())
    return f'<dl>{"".join(lines)}</dl>'
