from dataclasses import replace

import pytest

from setcmas_tools import Run, simulate
from setcmas_tools.comparison.experiment import experiment_verdict
from setcmas_tools.records.safety import safety_record
from setcmas_tools.report.page import report_page
from setcmas_tools.report.pair import Pair


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    """Folders of a simulation, and of the same with a safety record that stops robot 1 for 2 s."""
    folder = tmp_path_factory.mktemp('runs')
    run = simulate('nav_wp', 1, 10.0, limits='burger')
    states = [(float(t), 1, 'moving' if not 3 <= t < 5 else 'stopped', False) for t in range(10)]
    watched = replace(run, tables=replace(run.tables, safety=safety_record(states)))
    return run.save(folder / 'sim'), watched.save(folder / 'lab')


def test_an_experiment_is_told_whichever_comes_first(runs):
    for paths in (runs, runs[::-1]):
        verdict = experiment_verdict(paths, [Run.load(path) for path in paths], lambda _: None)

        assert verdict.title.endswith(f'lab against simulation {runs[0]}')
        assert verdict.found[1].stopped == 2.0
        assert verdict.lines[0].startswith('tb3_1 stays with the simulation')
        assert verdict.table('html').count('<tr>') == 2


def test_two_simulations_get_no_verdict(runs):
    assert experiment_verdict(runs[:1] * 2, [Run.load(runs[0])] * 2, lambda _: None) is None


def test_the_verdict_is_on_the_page(runs):
    sim, lab = map(Run.load, runs)
    page = report_page(Pair('sim', sim, 'lab', lab, lambda _: None, runs))

    assert 'Experiment against simulation' in page
    assert 'safety stopped it for 2.0 s' in page
