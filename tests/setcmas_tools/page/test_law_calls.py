from dataclasses import replace

import numpy as np
import pytest
from report_pages import HOSTILE, unpacked

from setcmas_ctrl import network
from setcmas_tools.offline.engine import simulate
from setcmas_tools.page import law_calls
from setcmas_tools.page.law_calls import Knowledge, calls_entry, failure_at
from setcmas_tools.page.run_history import RunHistory
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo


def test_each_call_has_its_wanted_velocity_and_the_outcome(failed_run):
    calls = calls_entry(RunHistory(failed_run))
    rows = failed_run.commands.of(3)

    assert np.allclose(unpacked(calls[3]['t']), rows.t)
    assert np.allclose(unpacked(calls[3]['vx']), rows.vx, rtol=0, atol=6e-5)
    words = {unpacked(calls[3]['t'])[place]: outcome for place, outcome in calls[3]['words']}
    assert [(t, kind) for t, (kind, _) in words.items()] == [
        (0.0, 'saturated'), (1.2, 'failed'), (1.6, 'saturated'),
    ]  # fmt: skip
    assert words[1.2][1] == f'Its law failed in line 10 of law.py: ValueError: {HOSTILE}'
    assert calls[2]['words'] == [(0, ('', ''))]


def test_what_a_robot_knew_is_what_its_links_brought(failed_run):
    history = RunHistory(failed_run)
    knowledge, own = Knowledge(history), calls_entry(history)[1]
    t = unpacked(own['t'])

    assert [one['number'] for one in own['known']] == [2, 3]
    for one in own['known']:
        for place in (0, 5, 12):
            known = knowledge.of(1, t[place])[0][:2, one['number'] - 1]
            shown = [unpacked(one['x'])[place], unpacked(one['y'])[place]]
            assert np.allclose(shown, known, rtol=0, atol=6e-5, equal_nan=True)


def test_the_page_names_the_filter_and_that_all_poses_are_known():
    run = simulate('consensus', 4, 16.0, filter='barrier', warn=lambda _: None)
    own = calls_entry(RunHistory(run))[1]

    assert 'known' not in own
    assert any(kind == 'overruled' for _, (kind, _) in own['words'])
    assert np.allclose(unpacked(own['allowedX']), run.commands.of(1).allowed.vx, atol=6e-5)


def test_failures_are_shown_without_commands_too(failed_run):
    tables = failed_run.tables
    bare = Run(type(tables)(tables.fleet), RunInfo(failures=failed_run.info.failures))

    calls = calls_entry(RunHistory(bare))

    assert set(calls) == {1, 3}
    assert [kind for _, (kind, _) in calls[3]['words']] == ['failed']


def failing(robot, nb_robots, poses, t):
    if robot == 2 and 2.0 <= t < 4.0:
        return (1.0 / 0.0, 0.0) if t < 3.0 else None
    return 0.2, 0.0


def test_a_failure_lasts_until_another_one_or_until_the_law_works(tmp_path):
    run = Run.load(simulate(failing, 2, 6.0, warn=lambda _: None).save(tmp_path / 'run'))
    divides, returns = (failure_at(run, 2, t) for t in (2.5, 3.9))

    assert 'ZeroDivisionError' in divides.text
    assert (divides.t, divides.until) == (2.0, 3.0)
    assert 'control returned None' in returns.text
    assert [failure_at(run, *call) for call in ((2, 1.0), (2, 4.0), (1, 2.5))] == [None] * 3


RING = {'graph': 'ring'}
CASES = {
    'ideal': {},
    'ring': RING,
    'late': {'delay': 0.25},
    'lossy': RING | {'loss': 0.4, 'delay': 0.15},
    'noisy': {'noise': 0.1},
    'by_event': RING | {'event_triggered': True, 'delay': 0.1, 'loss': 0.2},
    'near': {'range': 6.0, 'loss': 0.1},
}


def witnessed(**options):
    """Simulate a law that keeps what it is given; returns the run and that by robot and time."""
    given = {}

    def control(robot, nb_robots, poses, t):
        given[robot, t] = poses.copy()
        heard = np.nan_to_num(poses[:2] - poses[:2, robot - 1 : robot])
        return tuple(heard.mean(axis=1) + 0.1 * robot)

    return simulate(control, 4, 12.0, seed=3, **options), given


@pytest.mark.parametrize('case', CASES)
def test_it_is_what_each_law_was_given(case, tmp_path):
    run, given = witnessed(**CASES[case])
    loaded = Run.load(run.save(tmp_path / 'run'))
    knowledge = Knowledge(RunHistory(loaded))

    assert len(given) == 4 * 60
    for (robot, t), poses in given.items():
        known, reason = knowledge.of(robot, t)
        assert not reason
        np.testing.assert_allclose(known, poses, atol=1e-8)


@pytest.mark.parametrize('case', CASES)
def test_messages_are_those_that_each_law_received(case, tmp_path):
    given = {}

    def control(robot, nb_robots, poses, t):
        received = network.received().items()
        given[robot, round(t, 6)] = {sender: message.t for sender, message in received}
        network.send({'a': [robot, t]} if robot > 1 else t)
        return 0.1 * robot, 0.1

    run = simulate(control, 4, 8.0, seed=3, **CASES[case])
    entries = calls_entry(RunHistory(Run.load(run.save(tmp_path / 'run'))))

    assert len(given) == 4 * 40
    for (robot, t), received in given.items():
        place = round(5 * t)
        known = {one['number']: one['sent'] for one in entries[robot]['known'] if 'sent' in one}
        shown = {sender: unpacked(sent)[place] for sender, sent in known.items()}
        shown = {sender: sent for sender, sent in shown.items() if np.isfinite(sent)}
        assert shown == pytest.approx(received)
    assert entries[1]['messages']['texts'][1] == (1, '0.2')
    assert entries[2]['messages']['texts'][1] == (1, 'a = [2, 0.2]')


def test_links_that_come_and_go(tmp_path):
    graph = tmp_path / 'graph.yaml'
    graph.write_text(
        'repeat: true\nsegments:\n'
        '- {duration: 2, edges: [1 - 2]}\n- {duration: 3, edges: [3 - 4, 2 <- 3]}\n'
    )
    run, given = witnessed(graph=graph, delay=0.3, loss=0.2)
    knowledge = Knowledge(RunHistory(run))

    for (robot, t), poses in given.items():
        np.testing.assert_allclose(knowledge.of(robot, t)[0], poses, atol=1e-12)


def test_between_two_calls_it_is_that_of_the_first_one_but_for_itself():
    run, given = witnessed(**RING)
    known, _ = Knowledge(RunHistory(run)).of(2, 5.15)

    np.testing.assert_array_equal(known[:, 0], given[2, 5.0][:, 0])
    np.testing.assert_array_equal(known[:, 1], run.poses[51, :, 1])


def test_unknown_values_are_not_made_up():
    run, _ = witnessed(**CASES['lossy'])
    over_ros = replace(run, info=replace(run.info, started='2026-11-21T16:02:11+0000'))
    unknown = replace(run, info=replace(run.info, scenario={}))
    otherwise = replace(run, info=replace(run.info, scenario={**run.parameters, 'seed': 4}))

    for one, word in (
        (over_ros, 'real-time'),
        (unknown, 'the delay'),
        (otherwise, 'do not reproduce'),
    ):
        known, reason = Knowledge(RunHistory(one)).of(1, 3.0)
        assert known is None
        assert reason.startswith('not known: ')
        assert word in reason


@pytest.mark.parametrize(('most', 'passes'), [(100, 1), (0, 0)])
def test_sent_values_are_read_once_and_not_where_there_are_too_many(monkeypatch, most, passes):
    class Counted(list):
        passes = 0

        def __iter__(self):
            Counted.passes += 1
            return super().__iter__()

    run = simulate('leader_election', 4, 2.0)
    sent = Counted(run.messages)
    monkeypatch.setattr(law_calls, '_MOST_MESSAGES', most)
    changed = replace(run, tables=replace(run.tables, messages=sent))
    known = Knowledge(RunHistory(changed))
    monkeypatch.setattr(known, 'of', lambda *_: (None, 'not asked'))
    monkeypatch.setattr(law_calls, 'Knowledge', lambda _: known)
    calls = calls_entry(RunHistory(changed))

    assert Counted.passes == passes
    assert [robot for robot, one in calls.items() if 'messages' in one] == [1, 2, 3, 4][: 4 * most]
