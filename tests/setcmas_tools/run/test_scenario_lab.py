"""The lab of a scenario: what a scenario file may tighten, and what a recorded run keeps."""

from dataclasses import replace
from types import MappingProxyType

import pytest
from processes import run_here

from setcmas_expe.lab.lab_file import LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Arena
from setcmas_tools.run.run_folder import inputs_of, kept_record
from setcmas_tools.run.run_info import RunInfo, write_info
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.run.scenario_lab import bounded_lab_options, check_tightens, in_lab

TIGHT = """\
algo: consensus
nb_robots: 2
emulate: true
arena: [-2, 2, -2, 2]
min_separation: 0.5
obstacles: disc 0 1.5 0.1
accel: 0.4
"""


def lab_of(scenario, typed=MappingProxyType({}), from_file=True):
    return bounded_lab_options(scenario, typed, from_file).chosen()


def kept_run(scenario, folder):
    """Write the run.yaml of an emulated run, with its inputs; return the recorded scenario."""
    found = in_lab(scenario, lab_of(scenario)).found()
    inputs = inputs_of(found)
    folder.mkdir()
    for one in inputs:
        one.write_to(folder / one.folder)
    write_info(RunInfo(scenario=kept_record(found, inputs)), folder)
    return Scenario.load(folder / 'run.yaml')


def test_a_scenario_tightens_its_lab_and_the_run_repeats_in_the_same(tmp_path):
    (tmp_path / 'tight.yaml').write_text(TIGHT)
    scenario = Scenario.load(tmp_path / 'tight.yaml')
    lab = lab_of(scenario)
    assert (lab.arena, lab.min_separation, lab.accel) == ((-2, 2, -2, 2), 0.5, 0.4)

    again = kept_run(scenario, tmp_path / 'out')
    assert lab_of(again, from_file=False) == lab  # expe out --emulate
    assert lab_of(again) == lab  # expe out
    (tmp_path / 'small.yaml').write_text('arena: {x: [-1, 1], y: [-1, 1]}')
    with pytest.raises(SetcmasError, match='arena of the scenario loosens'):
        lab_of(again, {'lab': tmp_path / 'small.yaml'})


def test_a_scenario_that_loosens_its_lab_starts_nothing(tmp_path):
    (tmp_path / 'wide.yaml').write_text(TIGHT.replace('[-2, 2, -2, 2]', '[-9, 9, -9, 9]'))
    result = run_here('expe', 'wide.yaml', '-o', 'out', cwd=tmp_path)
    assert result.returncode == 2
    assert 'arena of the scenario loosens what the lab file sets' in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ['wide.yaml']


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'min_separation': 0.2}, 'min_separation of the scenario loosens'),
        ({'filter': 'none'}, 'filter of the scenario loosens'),
        ({'limits': 'waffle'}, 'limits of the scenario loosens'),
        ({'arena': (-99, 99, -99, 99)}, 'arena of the scenario loosens'),
        ({'without_guard': True}, 'without_guard of the scenario loosens'),
    ],
)
def test_a_scenario_tightens_what_a_lab_sets_and_never_loosens_it(changes, message):
    bounds = replace(LabOptions(filter='barrier').chosen(), arena=Arena(-2, 2, -2, 2))
    arena = changes.get('arena', (-1, 1, -1, 1))
    loose = LabOptions(**{'filter': 'barrier', **changes, 'arena': Arena(*arena)}).chosen()

    tight = LabOptions(filter='barrier', arena=Arena(-1, 1, -1, 1), accel=0.1)
    check_tightens(tight.chosen(), bounds)
    with pytest.raises(SetcmasError, match=message):
        check_tightens(loose, bounds)


def test_a_scenario_needs_the_lidar_stop_of_its_lab():
    lab = LabOptions().chosen()
    with pytest.raises(SetcmasError, match='lidar_stop of the scenario loosens'):
        check_tightens(lab, replace(lab, lidar_stop=True))
