"""The document of a page: its modules as one script, its texts and data as nothing but that."""

import base64
import hashlib
import io
import re
from dataclasses import replace

import pytest
from PIL import Image
from report_pages import HOSTILE, LAW, Page

from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function, ScriptFailure
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.document import document, element, page_content
from setcmas_tools.page.report_file import (
    Pair,
    check_page,
    listings,
    marks_of,
    page_named_after,
    plot_pictures,
    report_page,
)
from setcmas_tools.plots.plot import plots_of
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState, this_origin


def test_texts_and_data_are_never_html():
    content = page_content(charts=[{'name': HOSTILE, 'values': {}}])
    page = Page(document(HOSTILE, [element('p', HOSTILE + '\x00\x1b')], content))

    assert page.data['charts'][0]['name'] == HOSTILE
    assert HOSTILE in page.shown
    assert not [tag for tag, _ in page.elements if tag == 'img']


def test_only_a_live_page_connects():
    assert "connect-src 'self'" not in document('', [], page_content())
    assert "connect-src 'self'" in document('', [], page_content(live={'commands': False}))


MOST_BYTES = 1_000_000


@pytest.fixture(scope='session')
def page(failed_run):
    return report_page(Pair('failed', failed_run))


def test_what_comes_from_the_run_is_text(page):
    read = Page(page)

    assert read.shown.count(HOSTILE) >= 4  # docstring, line, and both places of the message
    assert [tag for tag, _ in read.elements].count('script') == 2
    for tag, attributes in read.elements:
        assert not [name for name in attributes if name.startswith('on')]
        if tag == 'img':
            assert attributes['src'].startswith(('data:image/png;', 'data:image/svg+xml;'))


def test_only_its_own_script_may_run_and_nothing_is_fetched(page):
    policy = re.search(r'content="(default-src[^"]*)"', page)[1].replace('&#39;', "'")
    script = page.rpartition('<script type="module">')[2].partition('</script>')[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()

    assert f"script-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none';")
    assert 'http' not in policy
    assert not re.findall(r'(?:src|href)="(?!data:)', page)


@pytest.mark.nightly
def test_a_run_of_a_minute_with_eight_robots_fits_into_a_mail():
    run = simulate('consensus', 8, 60.0, event_triggered=True, delay=0.2)

    assert len(report_page(Pair('run', run)).encode()) < MOST_BYTES


@pytest.fixture
def no_plots(monkeypatch):
    """Leave out the plots, which take most of the time."""
    monkeypatch.setattr('setcmas_tools.page.report_file.plot_pictures', lambda _: [])


def test_a_failed_run_says_so_with_command_and_versions(failed_run, no_plots):
    info = RunInfo(
        ['setcmas', 'run', '--algo', 'my law.py'],
        failed_run.outcome,
        {'nb_robots': 3, 'range': None, 'set': {'K': 1}, 'seed': 7},
        started='2026-11-21T16:02:11-0500',
        origin=this_origin(),
    )
    read = Page(report_page(Pair('failed', replace(failed_run, info=info))))

    for text in (
        '4 s, started 2026-11-21 16:02:11',
        'complete, but law.py failed for robots 1,3',
        "setcmas run --algo 'my law.py'",
        'set.K',
        'numpy',
    ):
        assert text in read.shown
    assert 'range' not in read.shown


@pytest.mark.parametrize('lines', ['\n    9 | x', ''])
def test_a_run_that_died_gives_the_reason_and_its_lines_if_it_has_more(
    failed_run, no_plots, lines
):
    outcome = Outcome(RunState.DIED, detail=f'tb3_1: killed{lines}')
    read = Page(report_page(Pair('failed', replace(failed_run, info=RunInfo(outcome=outcome)))))

    assert read.shown.count('tb3_1: killed') == 1 + bool(lines)


def test_the_other_run_is_there_with_what_differs(failed_run, no_plots):
    other = simulate('consensus', 3, 4.0)
    read = Page(report_page(Pair('failed', failed_run, 'other', other)))

    assert len(read.data['others']) == 3
    assert 'compared with other: consensus, 3 robots, 4 s, complete' in read.shown
    assert 'What differs' in read.shown
    assert 'delay: 0.3 -> 0.0' in read.shown
    assert 'm apart (RMS)' in read.shown


def test_runs_with_nothing_in_common_get_a_page_too(failed_run, no_plots):
    from runs import run_of

    from setcmas_tools.run.fleet_motion import fleet_table

    told = []
    stranger = run_of(fleet_table([[t / 10, 9, 0, 0, 0, 0, 0] for t in range(30)]))
    pair = Pair('failed', failed_run, 'stranger', stranger, told.append)

    assert Page(report_page(pair)).data['others'][0]['number'] == 9
    assert told == ['no robot is in both runs long enough to compare them']


def failure(t, robot, until=None, text='KeyError: 1', line=7):
    told = f'law.py, line {line}: {text}\n    {line} | x'
    return ScriptFailure(t, robot, Function.CONTROL, 'law.py', line, told, until)


def test_failures_stand_at_their_lines(failed_run):
    [(name, what, lines)] = listings(failed_run)
    marked = {n: marks for n, (_, marks) in enumerate(lines, 1) if marks}

    assert (name, what) == ('law.py', 'control law')
    assert [text for text, _ in lines] == LAW.splitlines()
    assert list(marked) == [8, 10]
    [first], [second] = marked.values()
    assert (first.robots, first.when) == ('robot 1', 't = 2.2 s to the end')
    assert first.text.startswith('IndexError: index 7 is out of bounds')
    assert (second.robot, second.t, second.when) == (3, 1.2, 't = 1.2 s to 1.6 s')
    assert second.text == f'ValueError: {HOSTILE}'


def test_equal_failures_are_reported_together_and_by_time():
    marks = marks_of([
        failure(2.0, 4), failure(1.0, 2, 1.4), failure(3.0, 2, 3.2), failure(0.5, 1, 0.7, 'Oh'),
    ])  # fmt: skip

    assert [(one.robots, one.when, one.text) for one in marks] == [
        ('robot 1', 't = 0.5 s to 0.7 s', 'Oh'),
        ('robots 2,4', 't = 1.0 s to the end, 2 times', 'KeyError: 1'),
    ]


def test_two_runs_are_measured_and_drawn_together(monkeypatch):
    monkeypatch.setattr('setcmas_tools.page.report_file._png', lambda _: b'')
    run, other = (simulate('consensus', 2, 3.0, set={'K': k}) for k in (0.02, 0.05))
    pair = Pair('slow', run, 'fast', other)
    table, below = pair.metrics()
    names = [one.name for one in plot_pictures(pair)]

    assert re.findall(r'<th.*?>\s*(\w+)\s*</th>', table) == ['slow', 'fast', 'difference']
    assert below == []
    assert names[:3] == ['paths', 'distances', 'trajectories']
    shown = Page(report_page(pair)).shown
    assert 'set.K: 0.02 -> 0.05' in shown
    assert 'fast is 0.' in shown


@pytest.mark.nightly
def test_each_plot_is_there_and_small(failed_run):
    pictures = list(plot_pictures(Pair('failed', failed_run)))

    assert [one.name for one in pictures] == list(plots_of(failed_run))
    for one in pictures:
        content = base64.b64decode(one.url.removeprefix('data:image/png;base64,'))
        assert len(content) < 100_000
        picture = Image.open(io.BytesIO(content))
        assert picture.width > 400
        assert picture.mode == 'P'


def test_an_existing_page_is_overwritten_only_when_asked(tmp_path):
    page = tmp_path / 'out.html'
    page.touch()

    with pytest.raises(SetcmasError, match=r"out\.html' exists; --overwrite"):
        check_page(page)
    check_page(page, overwrite=True)


def test_a_page_is_named_after_its_runs(failed, failed_run, tmp_path):
    for path in (failed, failed / 'csv', failed / 'csv' / 'fleet.csv'):
        assert str(page_named_after([path])) == 'failed.html'
    other = failed_run.save(tmp_path / 'other')
    assert str(page_named_after([failed, other])) == 'failed_other.html'
