"""The page of a run as one file to hand in."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.limited_file import written_whole
from setcmas_tools.measures.comparison import flat
from setcmas_tools.page.content import run_content
from setcmas_tools.page.document import answers_html, checkbox, document, element, escaped, stage
from setcmas_tools.page.run_facts import Line, Mark, Pair, listings, marks_of, plot_pictures
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import find_run
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
    body = [
        _header(pair, cover),
        *_answers(cover),
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


def _answers(cover: Cover) -> Iterator[str]:
    if cover.answers:
        yield f'<section class="answers">\n{answers_html(cover.answers)}</section>'


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
    if pair.headline:
        yield element('p', f'{pair.headline}.')
    yield f'<div class="scroll metrics">{table}</div>'
    yield from (element('p', remark) for remark in remarks)
    if pair.differences:
        yield element('h2', 'What differs')
        yield f'<pre>{element("code", _joined(pair.differences))}</pre>'
    yield '</section>'


def _plots(pair: Pair) -> Iterator[str]:
    yield '<section>\n<h2>Plots</h2>\n<div class="scroll plots">'
    for one in plot_pictures(pair):
        yield f'<img src="{one.url}" alt="{escaped(one.name)}" style="--share: {one.share:.2f}">'
    yield '</div>\n</section>'


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
