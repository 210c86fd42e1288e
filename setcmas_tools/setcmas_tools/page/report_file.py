"""The page of a run, or of two, as one file to hand in."""

from __future__ import annotations

import io
import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.limited_file import written_whole
from setcmas_simu.script_calls import ScriptFailure
from setcmas_tools.measures.comparison import (
    Shifted,
    best_shift,
    differences,
    flat,
    metrics_table,
)
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_table
from setcmas_tools.page.content import run_content
from setcmas_tools.page.document import answers_html, checkbox, document, element, escaped, stage
from setcmas_tools.plots.plot import drawn_pictures, drawn_plots
from setcmas_tools.plots.style import data_url, plot_style, png
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import RunInput, find_run
from setcmas_tools.run.run_info import RunState

_ENDINGS = ('.html', '.htm')


def page_named_after(runs: Sequence[Path]) -> Path:
    """Return the page of a run, or of two, in the current folder, or raise SetcmasError."""
    return Path('_'.join(dict.fromkeys(map(_name_of, runs))) + '.html')


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


@dataclass(frozen=True)
class Cover:
    """What students add to the page of a run.

    Attributes:
        title: Replaces the title of the run; '' for none.
        names: Who hands it in; may be empty.
        answers: Their answers in Markdown; None for none.
    """

    title: str = ''
    names: str = ''
    answers: Path | None = None


_NO_COVER = Cover()


def write_report(
    paths: Sequence[Path],
    page: Path,
    warn: Callable[[str], None],
    cover: Cover = _NO_COVER,
) -> None:
    """Write the page of a run, or of two, with what students add.

    Raises:
        SetcmasError: A run or the answers cannot be read, or the file cannot be written.
    """
    text = report_page(loaded_pair(paths, warn), cover)
    with file_errors(f"'{page}' cannot be written"), written_whole(page) as file:
        file.write(text.encode(errors='replace').decode())


@dataclass(frozen=True)
class Pair:
    """A run, and possibly a second one.

    Attributes:
        name: Name of the run.
        other_name: Name of the second run; empty without one.
        warn: Shows metrics and plots that fail.
    """

    name: str
    run: Run
    other_name: str = ''
    other: Run | None = None
    warn: Callable[[str], None] = print

    @cached_property
    def shifted(self) -> Shifted | None:
        """Distance of the second run from this one; None if no robot is in both."""
        if self.other is None:
            return None
        try:
            return best_shift(self.run, self.other)
        except SetcmasError as error:
            self.warn(str(error))
            return None

    def metrics(self) -> tuple[str, list[str]]:
        """Return an HTML table of metrics, and the lines below it."""
        try:
            own = measure(self.run, self.warn)
            if self.other is None:
                return robots_table(own.parts, 'html'), fleet_lines(own.parts)
            both = [own, measure(self.other, self.warn)]
        except SetcmasError as error:
            return '', [str(error)]
        return metrics_table([self.name, self.other_name], both, 'html'), []


def loaded_pair(paths: Sequence[Path], warn: Callable[[str], None]) -> Pair:
    """Load a run, or two, as `Run.load` does, or raise SetcmasError."""
    names = [_name_of(path) for path in paths]
    if len(set(names)) < len(names):
        names = [f'{name} ({path})' for name, path in zip(names, paths, strict=True)]
    runs = [Run.load(path, warn) for path in paths]
    if len(runs) == 1:
        return Pair(names[0], runs[0], warn=warn)
    return Pair(names[0], runs[0], names[1], runs[1], warn)


def _name_of(path: Path) -> str:
    """Return the name of a run's folder or recording, or raise SetcmasError."""
    source = find_run(path)
    return source.stem.rstrip('_') or source.folder.resolve().name or 'run'


def report_page(pair: Pair, cover: Cover = _NO_COVER) -> str:
    """Return the page of a run, or of a run with another one over it."""
    body = [_header(pair, cover)]
    if cover.answers:
        body.append(f'<section class="answers">\n{answers_html(cover.answers)}</section>')
    body += [
        *_failures(pair.run),
        _stage(pair),
        *_metrics(pair),
        *_plots(pair),
        *(_script(*one) for one in listings(pair.run)),
        *_origin(pair.run),
    ]
    return document(cover.title or pair.run.title, body, run_content(pair.run, pair.other))


def _header(pair: Pair, cover: Cover) -> str:
    titled = f'{pair.run.title}, ' if cover.title else ''
    lines = [
        element('p', pair.name, 'soft'),
        element('h1', cover.title or pair.run.title),
        *([element('p', cover.names, 'names')] if cover.names else []),
        element('p', titled + _when(pair.run), 'soft'),
    ]
    if pair.other:
        text = f'compared with {pair.other_name}: {pair.other.title}, {_when(pair.other)}, '
        lines.append(f'<p class="soft">{escaped(text)}{_outcome("span", pair.other)}</p>')
    outcome = _outcome('p', pair.run, 'outcome ')
    return f'<header>\n<div>\n{_joined(lines)}\n</div>\n{outcome}\n</header>'


def _when(run: Run) -> str:
    """Return duration and date of a run in words."""
    duration = float(run.table.t[-1]) - max(0.0, float(run.table.t[0]))
    start = (run.info.started or '')[:19].replace('T', ' ')
    return f'{round(duration, 1):g} s' + (f', started {start}' if start else '')


def _outcome(tag: str, run: Run, kind: str = '') -> str:
    quality = 'good' if run.outcome.state is RunState.COMPLETE else 'bad'
    return element(tag, str(run.outcome).partition('\n')[0], kind + quality)


@dataclass(frozen=True)
class Mark:
    """A failure of a script, for all robots that failed alike.

    Attributes:
        robots: The robots, in words.
        t: Time of the first failure in s.
        when: Its period, in words.
        text: The error, in a line.
        place: File and line, in words; empty if they are not known.
    """

    robot: int
    robots: str
    t: float
    when: str
    text: str
    place: str


def marks_of(failures: list[ScriptFailure]) -> list[Mark]:
    """Return a mark for all robots that failed alike, sorted by time."""
    alike: dict[tuple[str, int | None, str], list[ScriptFailure]] = {}
    for one in failures:
        kind = one.first_line.partition(':')[0]  # what follows may have numbers in it
        alike.setdefault((one.script, one.line, kind), []).append(one)
    marks = [_mark(ones) for ones in alike.values()]
    return sorted(marks, key=lambda mark: mark.t)


def _mark(ones: list[ScriptFailure]) -> Mark:
    first = min(ones, key=lambda one: one.t)
    robots = robots_in_words(sorted({one.robot for one in ones}))
    times = len([one for one in ones if one.robot == first.robot])
    ends = [one.until for one in ones]
    until = 'to the end' if None in ends else f'to {max(end or 0.0 for end in ends):.1f} s'
    again = f', {times} times' if times > 1 else ''
    place = f'{first.script}, line {first.line}' if first.line else first.script
    when = f't = {first.t:.1f} s {until}{again}'
    return Mark(first.robot, robots, first.t, when, first.first_line, place)


def _failures(run: Run) -> Iterator[str]:
    lines = [
        f'<p>{_marked(mark)} {element("span", mark.place and f"({mark.place})", "soft")}</p>'
        for mark in marks_of(run.info.failures or [])
    ]
    detail = run.outcome.detail
    if not lines and detail not in str(run.outcome).partition('\n')[0]:
        lines = [element('p', detail)]
    if lines:
        yield f'<div class="note failure">\n{_joined(lines)}\n</div>'


def _marked(mark: Mark) -> str:
    """Return a failure with a button that shows the time when it arose."""
    button = f'<button class="time" data-t="{mark.t:g}" data-robot="{mark.robot}">'
    return f'{button}{escaped(f"{mark.robots}, {mark.when}")}</button> {escaped(mark.text)}'


def _stage(pair: Pair) -> str:
    options = [] if pair.run.record is None else [checkbox('links', 'links')]
    if not pair.other:
        return stage(options)
    options.append(checkbox('ghosts', f'{pair.other_name} (pale, dotted)'))
    note = element('p', f'Dashed lines in the charts: {pair.other_name}.', 'soft')
    return stage(options, note)


def _metrics(pair: Pair) -> Iterator[str]:
    table, remarks = pair.metrics()
    yield '<section>\n<h2>Metrics</h2>'
    if pair.shifted:
        yield element('p', f'{pair.other_name} {pair.shifted}.')
    yield f'<div class="scroll metrics">{table}</div>'
    yield from (element('p', remark) for remark in remarks)
    if pair.other and (different := differences(pair.run, pair.other)):
        yield element('h2', 'What differs')
        yield f'<pre>{element("code", _joined(different))}</pre>'
    yield '</section>'


_WIDEST_IN = 9.0
_DPI = 110
_COLOURS = 128
"""Enough for lines and letters with smooth edges."""


@dataclass(frozen=True)
class PlotPicture:
    """A plot of a page.

    Attributes:
        url: The PNG as a data URL.
        share: Its width as a share of the page's, which gives all plots the same letters.
    """

    name: str
    url: str
    share: float


def plot_pictures(pair: Pair) -> Iterator[PlotPicture]:
    """Yield the plots of a run; of two, first those of both."""
    with plot_style():
        figures: Iterable[tuple[str, Figure]] = ()
        if pair.other and pair.shifted:
            names, runs = [pair.name, pair.other_name], [pair.run, pair.other]
            figures = drawn_pictures(names, runs, [pair.shifted])
        for name, figure in chain(figures, drawn_plots(pair.run, pair.warn)):
            share = min(1.0, figure.get_figwidth() / _WIDEST_IN)
            yield PlotPicture(name, data_url('image/png', _png(figure)), share)


def _png(figure: Figure) -> bytes:
    small = io.BytesIO()
    picture = Image.open(io.BytesIO(png(figure, _DPI))).convert('RGB')
    picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(small, format='png', optimize=True)
    return small.getvalue()


def _plots(pair: Pair) -> Iterator[str]:
    yield '<section>\n<h2>Plots</h2>\n<div class="scroll plots">'
    for one in plot_pictures(pair):
        yield f'<img src="{one.url}" alt="{escaped(one.name)}" style="--share: {one.share:.2f}">'
    yield '</div>\n</section>'


_OPTIONS = {
    'algo': 'control law',
    'si_to_uni': 'si_to_uni',
    'ctc': 'triggering condition',
    'model': 'robot model',
}

Line = tuple[str, list[Mark]]
"""A line of a script, with its failures."""


def listings(run: Run) -> Iterator[tuple[str, str, list[Line]]]:
    """Yield name, role and lines of the scripts of a run, laws first, each with its modules."""
    for option, role in _OPTIONS.items():
        for given in (one for one in run.inputs if one.option == option):
            robots = f' of {robots_in_words(list(given.robots))}' if given.robots else ''
            for file, content in zip(given.files, given.contents, strict=True):
                what = role if file == given.path else f'module of {given.path.name}'
                yield file.name, what + robots, _lines(run, given, file, content)


def _lines(run: Run, given: RunInput, file: Path, content: bytes) -> list[Line]:
    failures = [
        one
        for one in run.info.failures or []
        if one.script == file.name and (not given.robots or one.robot in given.robots)
    ]
    return [
        # `--watch` loads other versions: a failure is shown at the line that it quotes.
        (line, marks_of([one for one in failures if one.line == n and line.strip() in one.text]))
        for n, line in enumerate(content.decode(errors='replace').splitlines() or [''], 1)
    ]


def _script(name: str, what: str, listed: list[Line]) -> str:
    lines = []
    for number, (text, marks) in enumerate(listed, 1):
        kind = ' class="at"' if marks else ''
        lines.append(f'<span{kind}><i>{number}</i> {escaped(text)}</span>')
        lines.extend(f'<span class="mark">{_marked(mark)}</span>' for mark in marks)
    head = f'<h2>{escaped(name)} {element("span", what, "soft")}</h2>'
    return f'<section class="listing">\n{head}\n<pre>{"".join(lines)}</pre>\n</section>'


def _origin(run: Run) -> Iterator[str]:
    info = run.info
    yield '<section>\n<h2>How it was made</h2>'
    if info.command:
        yield f'<pre>{element("code", shlex.join(info.command))}</pre>'
    made: dict[str, object] = {}
    if origin := info.origin:
        made = {'setcmas': origin.setcmas, **origin.versions, **origin.host}
        made['computer'] = made.pop('name', '')
    yield _terms([*made.items(), ('seed', info.seed)])
    given = [pair for pair in flat(info.parameters).items() if pair[1] not in (None, [])]
    yield f'<details>\n<summary>All options</summary>\n{_terms(given)}\n</details>\n</section>'


def _terms(entries: Iterable[tuple[str, object]]) -> str:
    lines = (element('dt', name) + element('dd', value) for name, value in entries)
    return f'<dl>\n{_joined(lines)}\n</dl>'


def _joined(lines: Iterable[str]) -> str:
    return '\n'.join(lines)
