"""Runs made together: equal to the last bit to runs alone, and made alone where they are not."""

import builtins
import os
from dataclasses import fields

import numpy as np
import pytest

from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_tools import simulate, sweep
from setcmas_tools.studies.workers.row import arguments_of, row_of
from setcmas_tools.studies.workers.together import (
    kind_of,
    rows_together,
    runs_together,
    simulation_of,
)

LINKS = {'graph': 'ring', 'delay': 0.3, 'loss': 0.2, 'noise': 0.05}
LAW = """
import builtins, os, random
import numpy as np
DOES = 'nothing'
def does(what):
    return DOES == what
{top}
def control(robotNo, nbRobots, poses, t):
    {call}
    return 0.1, 0.01 * robotNo
"""


def parameters(algo, nb_robots, **others):
    """Return those of three runs of 1.2 s by their numbers."""
    same = {'algo': str(algo), 'nb_robots': nb_robots, 'duration': 1.2, 'random_poses': 'auto'}
    return {k + 1: {**same, 'seed': 7 * k, 'set': {}, **others} for k in range(3)}


def bits(table):
    """Return all that is in a table of a run."""
    values = [getattr(table, one.name) for one in fields(table)]
    return [v.tobytes() if isinstance(v, np.ndarray) else repr(v) for v in values]


def assert_same(together, alone):
    assert together.info == alone.info
    assert together.tables.drawings == alone.tables.drawings
    assert bits(together.tables.fleet) == bits(alone.tables.fleet)
    assert bits(together.tables.commands) == bits(alone.tables.commands)
    if alone.record:
        assert bits(together.record) == bits(alone.record)


@pytest.mark.parametrize('algo', ALGORITHMS.offers())
@pytest.mark.parametrize('nb_robots', [1, 3, 8])
@pytest.mark.parametrize(
    'others',
    [{'limits': 'burger'}, {'event_triggered': True, 'threshold': 0.05, 'loss': 0.3}, LINKS],
    ids=['ideal', 'event-triggered', 'links'],
)
def test_runs_together_equal_runs_alone_to_the_last_bit(algo, nb_robots, others):
    warned = []
    given = [
        arguments_of(one, warned.append) for one in parameters(algo, nb_robots, **others).values()
    ]
    runs = runs_together([simulation_of(one) for one in given])

    assert len(runs) == 3
    for run, one in zip(runs, given, strict=True):
        alone = simulate(**one)
        if not alone.outcome.failed_laws:  # a law that fails is for runs alone
            assert_same(run, alone)


def test_numbers_that_are_drawn_while_loading_are_those_of_each_run(tmp_path):
    (tmp_path / 'law.py').write_text(
        'import numpy as np\nvx = 0.4 * np.random.rand()\n'
        'def control(robotNo, nbRobots, poses, t):\n    return vx, 0.0\n'
    )
    runs = parameters(tmp_path / 'law.py', 2)
    rows = rows_together(runs, lambda _: None)

    assert rows == [row_of(number, one) for number, one in runs.items()]
    assert len({row.numbers['path_length'] for row in rows}) == 3


def test_settings_may_differ_and_links_switch(tmp_path):
    graph = tmp_path / 'graph.yaml'
    graph.write_text(
        'segments:\n- {graph: ring, duration: 0.6}\n- {graph: star, duration: 0.5}\nrepeat: true\n'
    )
    runs = parameters('consensus', 4, delay=0.3, noise=0.1, graph=str(graph))
    for number, one in runs.items():
        one['set'] = {'K': 0.3 * number}
    rows = rows_together(runs, lambda _: None)

    assert len({kind_of(one) for one in runs.values()}) == 1
    assert rows == [row_of(number, one) for number, one in runs.items()]
    assert len({row.numbers['path_length'] for row in rows}) == 3


@pytest.mark.parametrize(
    ('top', 'call'),
    [
        ('', 'np.random.rand()'),
        ('', 'random.random()'),
        ('', 'np.random.seed(1)'),
        ('', 'builtins.shared = t'),
        ('', 'os.environ["SETCMAS_SHARED"] = str(t)'),
        ('np.seterr(under="raise")', ''),
        ('', 'assert not (does("fails") and t > 0.5)'),
    ],
)
def test_what_runs_would_share_makes_them_go_alone(tmp_path, monkeypatch, top, call):
    monkeypatch.setenv('SETCMAS_SHARED', '')
    monkeypatch.setattr(builtins, 'shared', None, raising=False)
    (tmp_path / 'law.py').write_text(LAW.format(top=top, call=call or 'pass'))
    runs = parameters(tmp_path / 'law.py', 2)
    runs[2]['set'] = {'DOES': 'fails'}

    with np.errstate():
        assert rows_together(runs, lambda _: None) == []


def test_what_cannot_go_together_is_of_no_kind():
    (one,) = list(parameters('consensus', 2).values())[:1]
    assert kind_of(one)
    for other in (
        {'algo': print}, {'ctc': 'near.py'}, {'model': 'burger'}, {'range': 2.0},
        {'duration': 1e5},
    ):  # fmt: skip
        assert not kind_of(one | other)


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='runs share a process')
def test_a_study_makes_runs_together_until_one_of_them_ends_the_process(tmp_path):
    (tmp_path / 'law.py').write_text(
        LAW.format(
            top=f"open({str(tmp_path / 'pids')!r}, 'a').write(str(os.getpid()) + '\\n')",
            call='does("ends") and t > 1 and os._exit(3)',
        )
    )
    study = sweep(
        tmp_path / 'law.py', 2, 2, vary={'DOES': ['nothing', 'ends']}, seeds=4, jobs=1,
        random_poses='auto',
    )  # fmt: skip

    assert study['state'].tolist() == ['complete'] * 4 + ['died'] * 4
    assert study['robots'].tolist() == [''] * 4 + ['1'] * 4
    assert len(set((tmp_path / 'pids').read_text().split())) == 2 + 1 + 4
