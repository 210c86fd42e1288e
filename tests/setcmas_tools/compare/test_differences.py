from dataclasses import replace

import pytest

from setcmas_tools.compare.differences import differences
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.law_output import safety_record
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState


@pytest.fixture(scope='session')
def run():
    return simulate('consensus', 3, 3.0)


def test_runs_of_different_robots_name_the_compared_ones(run):
    assert differences(run, simulate('consensus', 2, 3.0))[:2] == [
        'robots: 1-3 -> 1-2',
        '    distances are for robots 1-2 only; means are over all robots of each run',
    ]


def test_runs_of_different_lengths_show_their_ends(run):
    lines = differences(run, simulate('consensus', 3, 5.0))

    assert lines[0] == 'end: 3.0 s -> 5.0 s; metrics cover each run to its own end'


def test_a_law_that_failed_is_reported(run):
    failed = Outcome(RunState.FAILED, {'law.py': [1, 2]})
    other = replace(run, info=replace(run.info, outcome=failed))

    assert differences(run, other) == [
        'outcome: complete -> complete, but law.py failed for robots 1-2'
    ]


def test_a_run_without_a_description_is_reported_in_a_line(run):
    other = replace(run, info=RunInfo(), inputs=())

    assert differences(run, other) == ['options and versions of this run are not known']


def test_a_run_is_not_different_from_itself(run):
    assert differences(run, run) == []


def test_an_experiment_and_a_simulation_differ_in_options_that_both_have(run):
    own = {'vnom': 0.2, 'algo': run.parameters['algo'], 'limits.V_max': 0.21}
    info = replace(run.info, scenario=own)
    safety = safety_record([(0.0, 1, 'moving', False)])
    lab = replace(run, info=info, tables=replace(run.tables, safety=safety))

    assert differences(lab, run) == [
        'kind: experiment -> simulation; options that only one of them has are left out',
        'vnom: 0.2 -> 0.5',
    ]
