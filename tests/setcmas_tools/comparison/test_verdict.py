from dataclasses import replace

import numpy as np
import pytest

from setcmas_tools import simulate
from setcmas_tools.comparison.verdict import Reached, is_experiment, parted, verdicts
from setcmas_tools.identification.drive import Drive
from setcmas_tools.records.communication import CommunicationRecord, Counts
from setcmas_tools.records.safety import safety_record

T = np.arange(100) / 10


@pytest.fixture(scope='module')
def simulation():
    return simulate('nav_wp', 2, 30.0, limits='burger')


@pytest.fixture(scope='module')
def experiment():
    """Slow robots, of which safety stops the second from 3 to 5 s; links lose three messages."""
    run = simulate('nav_wp', 2, 30.0, model='burger', vnom=0.15)
    states = [(t, 2, 'moving' if not 3 <= t < 5 else 'stopped', False) for t in range(30)]
    record = CommunicationRecord(
        {1: Counts(10, 7, 3, 0.1)}, {}, np.zeros((0, 3)), np.zeros((0, 4))
    )
    return replace(
        run, tables=replace(run.tables, safety=safety_record(states), communication=record)
    )


def test_only_what_safety_watched_is_an_experiment(simulation, experiment):
    assert not is_experiment(simulation)
    assert is_experiment(experiment)


def test_each_robot_is_told_where_it_parts_and_why(simulation, experiment):
    t = np.arange(150) / 5
    commands = np.array([t, np.full(150, 0.2), np.full(150, 0.05)])
    drive = Drive(commands, '/tb3_1/cmd_vel', experiment.table.of(1))

    first, second = verdicts(simulation, experiment, {1: drive}).values()

    assert first.parted is not None
    assert first.rms > 0.1
    assert first.speed == Reached(0.2, pytest.approx(0.15, abs=0.002))
    assert first.turn is None  # none was asked
    assert (first.stopped, second.stopped) == (0.0, 2.0)
    assert (first.lost, second.lost) == (3, None)
    assert second.speed is None


def test_a_run_beside_itself_does_not_part(simulation):
    one = verdicts(simulation, simulation, {})[1]

    assert (one.parted, one.rms, one.delay) == (None, 0.0, 0.0)


def test_a_run_whose_fleet_is_seen_late_is_not_early(simulation):
    table = simulation.table
    tables = replace(simulation.tables, fleet=table.rows(table.t >= 3.0))
    late = replace(simulation, tables=tables)

    assert verdicts(simulation, late, {})[1].delay == 0.0


def test_robots_have_parted_when_they_stay_apart():
    distances = np.zeros(100)
    distances[20:30] = 0.2  # not for long
    assert parted(T, distances) is None
    distances[60:] = 0.2
    assert parted(T, distances) == pytest.approx(6.0)


def test_robots_that_are_apart_at_the_end_have_parted_however_late():
    distances = np.full(100, 0.02)
    distances[94:] = 0.3  # then safety ended the run
    assert parted(T, distances) == pytest.approx(9.4)
    distances[98:] = np.nan  # nobody saw it any more
    assert parted(T, distances) == pytest.approx(9.4)
