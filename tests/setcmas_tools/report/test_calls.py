import numpy as np
from report_pages import HOSTILE, unpacked

from setcmas_tools.offline.engine import simulate
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.replay.instant import Instants
from setcmas_tools.report.calls import calls_entry
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo


def test_each_call_tells_what_was_wanted_and_what_became_of_it(failed_run):
    calls = calls_entry(RunHistory(failed_run))
    rows = failed_run.commands.of(3)

    assert np.allclose(unpacked(calls[3]['t']), rows.t)
    assert np.allclose(unpacked(calls[3]['vx']), rows.vx, rtol=0, atol=6e-5)
    words = {unpacked(calls[3]['t'])[place]: told for place, told in calls[3]['words']}
    assert [(t, kind) for t, (kind, _) in words.items()] == [
        (0.0, 'saturated'), (1.2, 'failed'), (1.6, 'saturated'),
    ]  # fmt: skip
    assert words[1.2][1] == f'Its law failed in line 10 of law.py: ValueError: {HOSTILE}'
    assert calls[2]['words'] == [(0, ('', ''))]


def test_what_a_robot_knew_is_what_its_links_brought(failed_run):
    history = RunHistory(failed_run)
    instants = Instants(history)
    own = calls_entry(history)[1]
    t = unpacked(own['t'])

    assert [one['number'] for one in own['known']] == [2, 3]
    for one in own['known']:
        for place in (0, 5, 12):
            known = instants.of(1, t[place]).known[:2, one['number'] - 1]
            told = [unpacked(one['x'])[place], unpacked(one['y'])[place]]
            assert np.allclose(told, known, rtol=0, atol=6e-5, equal_nan=True)


def test_the_filter_is_told_and_that_all_is_known():
    run = simulate('consensus', 4, 16.0, filter='barrier', warn=lambda _: None)
    own = calls_entry(RunHistory(run))[1]

    assert 'known' not in own
    assert any(kind == 'overruled' for _, (kind, _) in own['words'])
    assert np.allclose(unpacked(own['allowedX']), run.commands.of(1).allowed.vx, atol=6e-5)


def test_without_commands_failures_are_told_all_the_same(failed_run):
    tables = failed_run.tables
    bare = Run(type(tables)(tables.fleet), RunInfo(failures=failed_run.info.failures))

    calls = calls_entry(RunHistory(bare))

    assert set(calls) == {1, 3}
    assert [kind for _, (kind, _) in calls[3]['words']] == ['failed']
