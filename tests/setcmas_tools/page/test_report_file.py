"""The document of a page: its modules as one script, its texts and data as nothing but that."""

import base64
import hashlib
import re
from dataclasses import replace

import pytest
from report_pages import HOSTILE, Page

from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function, ScriptFailure
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.report_file import (
    answers_html,
    check_page,
    failure_html,
    failures_alike,
    report_page,
    run_name,
)
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState, this_origin

MOST_BYTES = 1_000_000


@pytest.fixture(scope='session')
def page(failed_run):
    return report_page(failed_run, 'failed')


def test_what_comes_from_the_run_is_text(page):
    read = Page(page)

    assert read.shown.count(HOSTILE) >= 3  # docstring, line and message
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

    assert len(report_page(run, 'run').encode()) < MOST_BYTES


@pytest.fixture
def no_plots(monkeypatch):
    """Leave out the plots, which take most of the time."""
    monkeypatch.setattr('setcmas_tools.page.report_file.plot_pictures', lambda *_: [])


def test_a_failed_run_says_so_with_command_and_versions(failed_run, no_plots):
    info = RunInfo(
        ['setcmas', 'run', '--algo', 'my law.py'],
        failed_run.outcome,
        {'nb_robots': 3, 'range': None, 'set': {'K': 1}, 'seed': 7},
        started='2026-11-21T16:02:11-0500',
        origin=this_origin(),
    )
    read = Page(report_page(replace(failed_run, info=info), 'failed'))

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
    outcome = Outcome(RunState.DIED, detail=f'tb3_1: killed\x1b[2J{lines}')
    read = Page(report_page(replace(failed_run, info=RunInfo(outcome=outcome)), 'failed'))

    assert read.shown.count('tb3_1: killed') == 1 + bool(lines)
    assert '\x1b' not in read.shown


def failure(t, robot, until=None, text='KeyError: 1', line=7):
    told = f'law.py, line {line}: {text}\n    {line} | x'
    return ScriptFailure(t, robot, Function.CONTROL, 'law.py', line, told, until)


def test_an_existing_page_is_overwritten_only_when_asked(tmp_path):
    page = tmp_path / 'out.html'
    page.touch()

    with pytest.raises(SetcmasError, match=r"out\.html' exists; --overwrite"):
        check_page(page)
    check_page(page, overwrite=True)


def test_a_page_is_named_after_its_run(failed):
    for path in (failed, failed / 'csv', failed / 'csv' / 'fleet.csv'):
        assert run_name(path) == 'failed'


def test_failures_stand_at_their_lines_with_the_time_when_they_arose(failed_run, no_plots):
    html = report_page(failed_run, 'failed')
    listing = html.partition('<section class="listing">')[2].partition('</section>')[0]
    marked = re.findall(r'class="at" data-t="(.*?)" data-robot="(\d)"><i>(\d+)</i>', listing)

    assert marked == [('2.2', '1', '8'), ('1.2', '3', '10')]


def test_equal_failures_are_reported_together_and_by_time():
    found = failures_alike([
        failure(2.0, 4), failure(1.0, 2, 1.4), failure(3.0, 2, 3.2), failure(0.5, 1, 0.7, 'Oh'),
    ])  # fmt: skip

    assert [Page(f'<p>{failure_html(ones)}</p>').shown for ones in found] == [
        'robot 1, t = 0.5 s to 0.7 s Oh',
        'robots 2,4, t = 1.0 s to the end, 2 times KeyError: 1',
    ]


ATTACKS = [
    HOSTILE,
    '[x](javascript:alert(1))',
    '![x](data:text/html,<script>alert(1)</script>)',
    '<a href="x" onclick="alert(1)">x</a>',
]


def answers(text, folder):
    pytest.importorskip('markdown_it')
    (folder / 'answers.md').write_text(text, encoding='utf-8')
    return Page(answers_html(folder / 'answers.md'))


def test_markdown_becomes_headings_tables_and_code(tmp_path):
    text = '# Q1\n\nIt is $u = -K x^2$, ![x](x.png).\n\n|a|b|\n|-|-|\n|1|2|\n\n```\nx = 1\n```\n'
    page = answers(text, tmp_path)
    tags = [tag for tag, _ in page.elements]

    assert tags[:2] == ['h2', 'p']  # the title of the page is its only h1
    assert {'table', 'code'} <= {*tags}
    assert 'It is $u = -K x^2$' in page.shown


@pytest.mark.parametrize('text', ATTACKS)
def test_nothing_that_a_student_writes_runs_or_leads_to_a_script(tmp_path, text):
    for tag, attributes in answers(text, tmp_path).elements:
        assert tag not in ('script', 'img', 'iframe')
        assert not [name for name in attributes if name.startswith('on') or 'href' in name]


def test_answers_that_cannot_be_read_are_reported(tmp_path):
    (tmp_path / 'word.md').write_bytes(b'\xff\xfe\x00')

    for name, message in (('gone.md', 'cannot be read'), ('word.md', 'a text file in UTF-8')):
        with pytest.raises(SetcmasError, match=message):
            answers_html(tmp_path / name)
