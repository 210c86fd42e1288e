import math

import numpy as np
import pytest
from report_pages import HOSTILE, unpacked
from runs import run_of

from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.content import (
    calls_entry,
    charts_entry,
    common_times,
    fleet_entry,
    plane_entry,
)
from setcmas_tools.page.instant import Instants, curves
from setcmas_tools.page.looks import SCALE, changes, packed
from setcmas_tools.page.run_history import RunHistory
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo


def history_of(t, nb_robots=1, x=0.0):
    rows = [
        np.array(np.broadcast_arrays(t, robot, x, robot, 0.0, 0.5, 0.0)).T
        for robot in range(1, nb_robots + 1)
    ]
    return RunHistory(run_of(fleet_table(np.concatenate(rows))))


def test_poses_and_speeds_are_those_of_the_table(failed_run):
    history = RunHistory(failed_run)
    t = common_times(history)

    assert t.tolist() == [k / 10 for k in range(41)]
    for entry in fleet_entry(history, t):
        rows = failed_run[entry['number']]
        for name in ('x', 'y', 'v', 'omega'):
            assert np.allclose(unpacked(entry[name]), getattr(rows, name), rtol=0, atol=6e-5)
        assert entry['breaks'] == []


def test_a_robot_that_is_put_elsewhere_leaves_a_gap():
    t = np.arange(21) / 10
    history = history_of(t, x=np.where(t < 1.0, 0.5 * t, 9.0 + 0.5 * t))

    [entry] = fleet_entry(history, common_times(history))

    assert entry['breaks'] == [10]


@pytest.mark.parametrize(
    ('t', 'nb_robots', 'times'),
    [
        (np.arange(0.0, 3600.0), 100, np.arange(0.0, 3600.0, 5.0)),
        (np.array([0.0]), 1, [0.0]),
        (np.array([0.34, 0.36]), 1, [0.34]),
        (np.array([-2.0, 0.0, 0.3]), 1, [0.0, 0.1, 0.2, 0.3]),
    ],
)
def test_times_are_few_enough_for_a_mail_and_begin_with_the_first_command(t, nb_robots, times):
    assert np.allclose(common_times(history_of(t, nb_robots)), times)


def test_numbers_come_back_to_a_tenth_of_a_millimetre_and_gaps_stay():
    values = np.cumsum(np.random.default_rng(1).normal(size=500))
    values[[0, 17, 18, 499]] = math.nan

    assert np.allclose(unpacked(packed(values)), values, rtol=0, atol=0.6 / SCALE, equal_nan=True)
    assert packed([]) == []
    assert packed([math.nan]) == [None]


def test_rare_changes_are_stored_where_they_occur():
    assert changes(['a', 'a', 'b', 'b', 'a']) == [(0, 'a'), (2, 'b'), (4, 'a')]
    assert changes([]) == []


def test_drawings_and_links_are_those_of_the_run(failed_run):
    entry = plane_entry(RunHistory(failed_run))

    assert [drawn['marker'] for drawn in entry['drawings']] == [True] * 3
    own = entry['drawings'][0]
    assert np.allclose(unpacked(own['x']), unpacked(own['t']))  # as the script draws it
    assert [look[1] for _, look in own['looks']] == ['#ff0000']
    assert entry['links'] == failed_run.record.changes.tolist()
    assert entry['sent'] == {}


def test_references_arena_and_obstacles_are_there():
    run = simulate('nav_wp', 1, 2.0, arena=(-6, 6, -6, 6), obstacles='disc 3 3 0.5')
    entry = plane_entry(RunHistory(run))
    marked, joined = entry['references']

    assert marked['points'] == joined['points'] == [list(p) for p in run.references.values['WPL']]
    assert (marked['marked'], joined['joined']) == (True, True)
    assert entry['arena'] == (-6, 6, -6, 6)
    assert entry['discs'] == ((3, 3, 0.5),)


def test_broadcasts_by_event_are_shown():
    run = simulate('consensus', 3, 5.0, event_triggered=True)
    entry = plane_entry(RunHistory(run))

    for robot, times in run.record.trigger_times.items():
        assert np.allclose(unpacked(entry['sent'][robot]), times)


def test_each_call_has_its_wanted_velocity_and_the_outcome(failed_run):
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


def test_curves_are_those_of_the_plots_with_the_other_run_dashed():
    run, other = (simulate('consensus', 3, 4.0, seed=1, set={'K': k}) for k in (0.02, 0.05))
    t = np.arange(41) / 10
    charts = {chart['name']: chart for chart in charts_entry(run, other, t)}

    assert list(charts) == ['Difference', 'Disagreement', 'Least separation', 'Speed']
    for own, curve in zip(list(charts.values())[1:], curves(run), strict=True):
        for robot, values in curve.values.items():
            assert np.allclose(unpacked(own['values'][robot]), values, atol=6e-5, equal_nan=True)
    disagreement = charts['Disagreement']
    assert unpacked(disagreement['other'][0])[-1] < unpacked(disagreement['values'][0])[-1]


def test_at_other_times_nothing_is_known():
    run = simulate('consensus', 2, 1.0)
    chart = charts_entry(run, None, np.array([0.5, 0.55, 7.0]))[0]

    assert [step is None for step in chart['values'][0]] == [False, True, True]
    assert 'other' not in chart
