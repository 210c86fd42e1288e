import base64
import io
import re

import pytest
from PIL import Image
from report_pages import HOSTILE, LAW

from setcmas_simu.script_calls import Function, ScriptFailure
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.run_facts import Pair, listings, marks_of, plot_pictures
from setcmas_tools.plots.plot import plots_of
from setcmas_tools.plots.style import plot_style


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


def test_two_runs_are_measured_and_drawn_together():
    run, other = (simulate('consensus', 2, 3.0, set={'K': k}) for k in (0.02, 0.05))
    pair = Pair('slow', run, 'fast', other)
    table, below = pair.metrics()
    with plot_style():
        names = [name for name, _ in pair.figures()]

    assert re.findall(r'<th.*?>\s*(\w+)\s*</th>', table) == ['slow', 'fast', 'difference']
    assert below == []
    assert names[:3] == ['paths', 'distances', 'trajectories']
    assert pair.differences == ['set.K: 0.02 -> 0.05']
    assert pair.headline.startswith('fast is 0.')


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
