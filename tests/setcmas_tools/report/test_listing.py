from dataclasses import replace

from report_pages import HOSTILE, LAW

from setcmas_simu.reports.reports import Function, ScriptFailure
from setcmas_tools.report.listing import listings, marks_of


def failure(t, robot, until=None, text='KeyError: 1', line=7):
    told = f'law.py, line {line}: {text}\n    {line} | x'
    return ScriptFailure(t, robot, Function.CONTROL, 'law.py', line, told, until)


def test_failures_stand_at_their_lines(failed_run):
    [listing] = listings(failed_run)
    marked = {n: marks for n, (_, marks) in enumerate(listing.lines, 1) if marks}

    assert [text for text, _ in listing.lines] == LAW.splitlines()
    assert list(marked) == [8, 10]
    [first], [second] = marked.values()
    assert (first.robots, first.when) == ('robot 1', 't = 2.2 s to the end')
    assert first.text.startswith('IndexError: index 7 is out of bounds')
    assert (second.robot, second.t, second.when) == (3, 1.2, 't = 1.2 s to 1.6 s')
    assert second.text == f'ValueError: {HOSTILE}'


def test_a_line_of_another_version_is_not_marked(failed_run):
    [mine, *others] = failed_run.inputs
    newer = replace(failed_run, inputs=(mine, *others))
    before = mine.contents
    mine.contents = [before[0].replace(b'poses[0, 7]', b'poses[0, 0]')]
    try:
        [listing] = listings(newer)
    finally:
        mine.contents = before

    assert [n for n, (_, marks) in enumerate(listing.lines, 1) if marks] == [10]


def test_robots_that_fail_alike_are_told_together_and_by_time():
    marks = marks_of([
        failure(2.0, 4), failure(1.0, 2, 1.4), failure(3.0, 2, 3.2), failure(0.5, 1, 0.7, 'Oh'),
    ])  # fmt: skip

    assert [(one.robots, one.when, one.text) for one in marks] == [
        ('robot 1', 't = 0.5 s to 0.7 s', 'Oh'),
        ('robots 2,4', 't = 1.0 s to the end, 2 times', 'KeyError: 1'),
    ]
