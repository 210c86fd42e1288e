import numpy as np
import pytest
from report_pages import HOSTILE
from runs import run_of

from setcmas_tools.measures.agreement import fleet_consensus
from setcmas_tools.measures.safety_metrics import fleet_separation
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.content import (
    calls_entry,
    charts_entry,
    common_times,
    failure_at,
    fleet_entry,
    plane_entry,
    states_at,
)
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_records import SafetyRecord


def numbers(values):
    """Return numbers of a page, NaN where it has none."""
    return np.array(values, dtype=float)


def run_with(t, nb_robots=1, x=0.0):
    rows = [
        np.array(np.broadcast_arrays(t, robot, x, robot, 0.0, 0.5, 0.0)).T
        for robot in range(1, nb_robots + 1)
    ]
    return run_of(fleet_table(np.concatenate(rows)))


def test_poses_and_speeds_are_those_of_the_table(failed_run):
    t = common_times(failed_run)

    assert t.tolist() == [k / 10 for k in range(41)]
    for entry in fleet_entry(failed_run, t):
        rows = failed_run[entry['number']]
        for name in ('x', 'y', 'v', 'omega'):
            assert np.allclose(numbers(entry[name]), getattr(rows, name), rtol=0, atol=6e-5)
        assert entry['breaks'] == []


def test_a_robot_that_is_put_elsewhere_leaves_a_gap():
    t = np.arange(21) / 10
    run = run_with(t, x=np.where(t < 1.0, 0.5 * t, 9.0 + 0.5 * t))

    [entry] = fleet_entry(run, common_times(run))

    assert entry['breaks'] == [10]


@pytest.mark.parametrize(
    ('t', 'nb_robots', 'times'),
    [
        (np.arange(0.0, 3600.0), 100, np.arange(0.0, 3600.0, 10.0)),
        (np.array([0.0]), 1, [0.0]),
        (np.array([0.34, 0.36]), 1, [0.34]),
        (np.array([-2.0, 0.0, 0.3]), 1, [0.0, 0.1, 0.2, 0.3]),
    ],
)
def test_times_are_few_enough_for_a_mail_and_begin_with_the_first_command(t, nb_robots, times):
    assert np.allclose(common_times(run_with(t, nb_robots)), times)


def test_each_call_has_its_wanted_velocity_and_the_outcome(failed_run):
    calls = calls_entry(failed_run)
    rows = failed_run.commands.of(3)

    assert np.allclose(numbers(calls[3]['t']), rows.t)
    assert np.allclose(numbers(calls[3]['vx']), rows.vx, rtol=0, atol=6e-5)
    words = {calls[3]['t'][place]: outcome for place, outcome in calls[3]['words']}
    assert [(t, kind) for t, (kind, _) in words.items()] == [
        (0.0, 'saturated'), (1.2, 'failed'), (1.6, 'saturated'),
    ]  # fmt: skip
    assert words[1.2][1] == f'Its law failed in line 10 of law.py: ValueError: {HOSTILE}'
    assert calls[2]['words'] == [(0, ('', ''))]


def test_the_page_names_the_filter():
    run = simulate('consensus', 4, 16.0, filter='barrier', warn=lambda _: None)
    own = calls_entry(run)[1]

    assert any(kind == 'overruled' for _, (kind, _) in own['words'])
    assert np.allclose(numbers(own['allowedX']), run.commands.of(1).allowed_vx, atol=6e-5)


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


def test_states_of_an_experiment():
    rows = [[t, 1, 0, 0, 0, 0, 0] for t in np.arange(-1, 3, 0.1)]
    record = SafetyRecord.in_order([0.0, 1.0], [1, 1], ['paused', 'moving'], [True, False])
    run = Run(fleet_table(rows), safety=record)

    found = states_at(run, 1, np.array([-0.5, 0.5, 1.0, 2.5]))

    assert found == [('moving', False), ('paused', True), ('moving', False), ('moving', False)]


def test_drawings_and_links_are_those_of_the_run(failed_run):
    entry = plane_entry(failed_run)

    assert [drawn['marker'] for drawn in entry['drawings']] == [True] * 3
    own = entry['drawings'][0]
    assert np.allclose(numbers(own['x']), numbers(own['t']))  # as the script draws it
    assert [look[1] for _, look in own['looks']] == ['#ff0000']
    assert entry['links'] == failed_run.record.changes.tolist()
    assert entry['sent'] == {}


def test_references_arena_and_obstacles_are_there():
    run = simulate('nav_wp', 1, 2.0, arena=(-6, 6, -6, 6), obstacles='disc 3 3 0.5')
    entry = plane_entry(run)
    marked, joined = entry['references']

    assert marked['points'] == joined['points'] == [list(p) for p in run.references.values['WPL']]
    assert (marked['marked'], joined['joined']) == (True, True)
    assert entry['arena'] == (-6, 6, -6, 6)
    assert entry['discs'] == ((3, 3, 0.5),)


def test_broadcasts_by_event_are_shown():
    run = simulate('consensus', 3, 5.0, event_triggered=True)
    entry = plane_entry(run)

    for robot, times in run.record.trigger_times.items():
        assert np.allclose(numbers(entry['sent'][robot]), times)


def test_charts_are_those_of_the_plots_and_metrics():
    run = simulate('consensus', 4, 20.0)
    t = common_times(run)
    charts = {one['name']: numbers([*one['values'].values()]) for one in charts_entry(run, t)}

    assert list(charts) == ['Disagreement', 'Least separation', 'Speed']
    consensus = fleet_consensus(run)
    ends = [consensus.disagreement_at_start_m, consensus.disagreement_at_end_m]
    assert np.allclose(charts['Disagreement'][0, [0, -1]], ends, atol=6e-5)
    least = fleet_separation(run).least_separation_m
    assert least - 6e-5 <= charts['Least separation'].min() < least + 0.01
    assert np.allclose(charts['Speed'][2], run['tb3_3'].v, atol=6e-5)
