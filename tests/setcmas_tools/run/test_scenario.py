"""Scenarios: made from values and files, checked, and written."""

import numpy as np
import pytest
import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_tools import Scenario, simulate

LAW = 'K = 1.0\ndef control(robotNo, nbRobots, poses, t):\n    return K, 0.0\n'
SQUARE = """\
version: 1
algo: square.py
set: {K: 0.5}
nb_robots: 3
duration: 2
poses: [[0, 0, 0], [1, 0], [2, 0, 1.5]]
loss: 1e-1
"""


@pytest.fixture
def square(tmp_path):
    """A scenario file, with its script in the same folder."""
    (tmp_path / 'square.py').write_text(LAW)
    file = tmp_path / 'square.yaml'
    file.write_text(SQUARE)
    return file


def test_a_file_an_option_and_an_argument_have_the_same_names(square):
    scenario = Scenario.load(square)

    assert scenario == Scenario.of(
        square.parent / 'square.py',
        set={'K': 0.5},
        nb_robots=3,
        duration=2,
        poses=[[0, 1, 2], [0, 0, 0], [0, 0, 1.5]],
        loss=0.1,
    )
    run = simulate(scenario)
    assert (run.poses == simulate(scenario.replace(loss=0.5), loss=0.1).poses).all()
    assert run.parameters['algo'] == 'inputs/algo/square.py'
    assert run.info.scenario['version'] == 1


def test_what_is_saved_is_loaded(square):
    scenario = Scenario.load(square)

    again = scenario.replace(noise=0.1).save(square.parent / 'again.yaml')

    assert yaml.safe_load(again.read_text())['version'] == 1
    assert yaml.safe_load(again.read_text())['algo'] == 'square.py'
    assert Scenario.load(again) == scenario.replace(noise=0.1)


@pytest.mark.parametrize(
    ('values', 'message'),
    [
        ({'algo': lambda *_: (0, 0)}, 'algo is a function'),
        ({'algo': 'consensus', 'graph': np.eye(2)}, 'graph is a matrix'),
        ({}, r"algo names '.*square\.py', which is outside"),
    ],
)
def test_what_no_file_can_hold_is_refused_by_name(square, values, message):
    (square.parent / 'other').mkdir()
    scenario = Scenario.of(square.parent / 'square.py', nb_robots=2).replace(**values)

    with pytest.raises(SetcmasError, match=message):
        scenario.save(square.parent / 'other' / 'out.yaml')
    assert not list((square.parent / 'other').iterdir())


@pytest.mark.parametrize(
    ('old', 'new', 'line', 'words'),
    [
        ('loss:', 'lost:', 7, 'did you mean loss'),
        ('loss: 1e-1', 'loss: 2', 7, 'loss is 2; it must be from 0 to 1'),
        ('loss: 1e-1', 'threshold: 2', 7, 'threshold needs event_triggered'),
        ('loss: 1e-1', 'graph: rng', 7, 'did you mean ring'),
        ('loss: 1e-1', 'model: brger', 7, 'did you mean burger'),
        ('loss: 1e-1', 'emulate: 1', 7, 'must be true or false'),
        ('K: 0.5', 'k: 0.5', 3, "no module-level name 'k'"),
        ('nb_robots: 3', 'nb_robots: 4', 6, '3 poses for 4 robots'),
        ('[1, 0]', '[1]', 6, 'such as [1.0, 2.0, 1.57]'),
        ('version: 1', 'version: 2', 1, 'must be 1'),
        ('algo: square.py', 'algo: consensis', 2, 'did you mean consensus'),
        ('algo: square.py', '', 1, 'there is no control law'),
    ],
)
def test_a_mistake_is_reported_with_its_line(square, old, new, line, words):
    square.write_text(SQUARE.replace(old, new))

    with pytest.raises(SetcmasError) as caught:
        Scenario.load(square)
    assert f'square.yaml, line {line}: ' in str(caught.value)
    assert words in str(caught.value)


def test_a_name_means_a_law_that_ships_never_a_script_of_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'consensus.py').write_text('raise SystemExit')
    (tmp_path / 'own').mkdir()
    file = tmp_path / 'own' / 'c.yaml'
    file.write_text('algo: consensus\nnb_robots: 2\nduration: 1\n')

    assert simulate(Scenario.load(file)).outcome.failed == {}


def test_a_fleet_of_one_and_links_that_lose_everything_are_noted():
    alone = Scenario.of('laplacian_consensus').notes_on_simulation
    lossy = Scenario.of('laplacian_consensus', nb_robots=2, loss=1.0).notes

    assert alone == [
        'the fleet has one robot, which has no neighbours; set nb_robots to 5 (--nb-robots 5)'
    ]
    assert lossy == ['loss is 1: no message arrives, so robots know only where the others started']
    assert Scenario.of('laplacian_consensus').notes == []  # for ctrl, the size is unknown
    assert Scenario.of('nav_wp').notes_on_simulation == []
