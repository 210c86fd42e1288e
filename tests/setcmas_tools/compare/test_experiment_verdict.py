from dataclasses import replace

import numpy as np
import pytest

from setcmas_tools.compare.experiment_verdict import (
    Reached,
    experiment_verdict,
    parted,
    verdicts,
)
from setcmas_tools.compare.robot_drive import Drive
from setcmas_tools.offline.engine import simulate
from setcmas_tools.page.report_file import report_page
from setcmas_tools.page.run_facts import Pair
from setcmas_tools.run.communication_record import CommunicationRecord, Counts
from setcmas_tools.run.law_output import safety_record
from setcmas_tools.run.run import Run

T = np.arange(100) / 10


@pytest.fixture(scope='session')
def simulation():
    return simulate('nav_wp', 2, 30.0, limits='burger')


@pytest.fixture(scope='session')
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


def test_each_robot_has_its_departure_and_the_reason(simulation, experiment):
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


def test_a_run_does_not_depart_from_itself(simulation):
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
    distances[98:] = np.nan  # motion capture lost it
    assert parted(T, distances) == pytest.approx(9.4)


@pytest.fixture(scope='session')
def runs(tmp_path_factory):
    """Folders of a simulation, and of the same with a safety record that stops robot 1 for 2 s."""
    folder = tmp_path_factory.mktemp('runs')
    run = simulate('nav_wp', 1, 10.0, limits='burger')
    states = [(float(t), 1, 'moving' if not 3 <= t < 5 else 'stopped', False) for t in range(10)]
    watched = replace(run, tables=replace(run.tables, safety=safety_record(states)))
    return run.save(folder / 'sim'), watched.save(folder / 'lab')


def test_an_experiment_is_recognised_in_either_order(runs):
    for paths in (runs, runs[::-1]):
        verdict = experiment_verdict(paths, [Run.load(path) for path in paths], lambda _: None)

        assert verdict.title.endswith(f'lab against simulation {runs[0]}')
        assert verdict.found[1].stopped == 2.0
        assert verdict.lines[0].startswith('tb3_1 stays with the simulation')
        assert len(verdict.table().rows) == 1


def test_two_simulations_get_no_verdict(runs):
    assert experiment_verdict(runs[:1] * 2, [Run.load(runs[0])] * 2, lambda _: None) is None


def test_the_verdict_is_on_the_page(runs, monkeypatch):
    monkeypatch.setattr('setcmas_tools.page.report_file.plot_images', lambda _: [])
    sim, lab = map(Run.load, runs)
    page = report_page(Pair('sim', sim, 'lab', lab, lambda _: None, runs))

    assert 'Experiment against simulation' in page
    assert 'safety stopped it for 2.0 s' in page
