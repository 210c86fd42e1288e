"""The worker's calls, in this process."""

import json
from pathlib import Path

import pytest

from setcmas_tools import simulate
from setcmas_tools.page import site_worker
from setcmas_tools.page.content import run_content

LAW = """
K = 0.5


def control(robotNo, nbRobots, poses, t):
    if t == 0 and robotNo == 2:
        print('hello <b>')
    x = y = 0.0
    for j in range(nbRobots):
        x -= K * (poses[0, robotNo - 1] - poses[0, j])
        y -= K * (poses[1, robotNo - 1] - poses[1, j])
    return x, y
"""
FAILS = LAW.replace('return x, y', 'return [x][int(t >= 1)], y')
FLEET = {'nb_robots': 3, 'duration': 4, 'loss': '0.2', 'graph': 'ring'}


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


class Page:
    """Calls `site_worker` in this process, and keeps what the page is sent meanwhile."""

    def __init__(self):
        self.said = []

    def call(self, call, **request):
        self.said.clear()
        return json.loads(site_worker.answer(call, json.dumps(request), self.say))

    def say(self, text):
        self.said.append(json.loads(text))

    def run(self, **request):
        return self.call('run', **{'scenario': FLEET, **request})


@pytest.fixture
def page():
    return Page()


def test_a_run_is_that_of_the_engine(page):
    answer = page.run(script=LAW, set={'K': '0.8'})
    Path('my_law.py').write_text(LAW)
    run = simulate('my_law.py', 3, 4.0, loss=0.2, graph='ring', set={'K': 0.8})

    assert answer['page'] == json.loads(json.dumps(run_content(run)))
    assert (answer['title'], answer['outcome']) == (run.title, 'complete')
    assert [row[0] for row in answer['metrics']['rows']] == ['tb3_1', 'tb3_2', 'tb3_3']
    assert any('least separation' in line for line in answer['metrics']['lines'])
    assert {'print': 'tb3_2: hello <b>\n'} in page.said
    assert {'reached': 0.2, 'of': 4.0} in page.said


def test_a_failing_line_is_named(page):
    answer = page.run(script=FAILS)

    assert answer['ok']
    assert answer['failures'][0] | {'text': ''} == {
        'robot': 1, 't': 1.0, 'file': 'my_law.py', 'line': 12, 'text': ''
    }  # fmt: skip
    assert 'IndexError' in answer['failures'][0]['text']


@pytest.mark.parametrize(
    ('request_', 'message'),
    [
        ({'script': 'x = ='}, 'my_law.py, line 1: SyntaxError'),
        ({'script': f'import missing_{LAW}'}, 'my_law.py, line 1: ModuleNotFoundError'),
        ({'script': LAW, 'name': '../law.py'}, "'../law.py' cannot be the name of a script"),
        ({'script': LAW, 'set': {'k': '1'}}, 'did you mean K?'),
        ({'algo': 'consensu'}, 'did you mean consensus?'),
        ({'scenario': {'nb_robots': 'x'}}, "nb_robots is 'x'; it must be a whole number"),
        ({'scenario': {'los': 1}}, 'did you mean loss?'),
    ],
)
def test_a_mistake_is_refused(page, request_, message):
    answer = page.run(**request_)

    assert not answer['ok']
    assert message in answer['error']


def test_a_triggering_condition_is_run(page):
    script = 'def ctc(pos, last_pos, t):\n    return t > 1\n'
    answer = page.run(script=script, function='ctc', scenario={'nb_robots': 3, 'duration': 2})

    assert answer['title'] == 'consensus, 3 robots'
    assert answer['page']['plane']['sent']


def test_output_is_limited(page):
    flood = LAW.replace("print('hello <b>')", "print('x' * 300_000)")
    page.run(script=flood)
    printed = ''.join(one.get('print', '') for one in page.said)

    assert len(printed) < 250_000
    assert printed.endswith('the script prints more, which is not shown\n')
