import numpy as np
from report_pages import HOSTILE, unpacked

from setcmas_ctrl import network
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.page.law_calls import calls_entry, failure_at, states_at
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.law_output import safety_record
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_tables import RunTables


def test_each_call_has_its_wanted_velocity_and_the_outcome(failed_run):
    calls = calls_entry(failed_run)
    rows = failed_run.commands.of(3)

    assert np.allclose(unpacked(calls[3]['t']), rows.t)
    assert np.allclose(unpacked(calls[3]['vx']), rows.vx, rtol=0, atol=6e-5)
    words = {unpacked(calls[3]['t'])[place]: outcome for place, outcome in calls[3]['words']}
    assert [(t, kind) for t, (kind, _) in words.items()] == [
        (0.0, 'saturated'), (1.2, 'failed'), (1.6, 'saturated'),
    ]  # fmt: skip
    assert words[1.2][1] == f'Its law failed in line 10 of law.py: ValueError: {HOSTILE}'
    assert calls[2]['words'] == [(0, ('', ''))]


def test_the_page_names_the_filter():
    run = simulate('consensus', 4, 16.0, filter='barrier', warn=lambda _: None)
    own = calls_entry(run)[1]

    assert any(kind == 'overruled' for _, (kind, _) in own['words'])
    assert np.allclose(unpacked(own['allowedX']), run.commands.of(1).allowed.vx, atol=6e-5)


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


def test_values_that_laws_sent_are_shown_as_text():
    def control(robot, nb_robots, poses, t):
        network.send({'a': [robot, t]} if robot > 1 else t)
        return 0.1 * robot, 0.1

    entries = calls_entry(simulate(control, 2, 2.0))

    assert entries[1]['messages']['texts'][1] == (1, '0.2')
    assert entries[2]['messages']['texts'][1] == (1, 'a = [2, 0.2]')


def test_states_of_an_experiment():
    rows = [[t, 1, 0, 0, 0, 0, 0] for t in np.arange(-1, 3, 0.1)]
    record = safety_record([(0.0, 1, 'paused', True), (1.0, 1, 'moving', False)])
    run = Run(RunTables(fleet_table(rows), safety=record))

    found = states_at(run, 1, np.array([-0.5, 0.5, 1.0, 2.5]))

    assert found == [('moving', False), ('paused', True), ('moving', False), ('moving', False)]
