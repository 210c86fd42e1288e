import pytest
from identified_robots import TRUTH, assert_found
from processes import PATIENT_LAB, refuses, run_here

from launch_scripts.cli import main
from setcmas_expe.emulation.emulated_lab import LAB_RATE_HZ
from setcmas_expe.emulation.emulated_mocap import LATENCY_S
from setcmas_tools import simulate
from setcmas_tools.measures.comparison import best_shift
from setcmas_tools.run.run import Run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'truth.yaml').write_text(TRUTH)
    return tmp_path


@pytest.mark.nightly
@pytest.mark.alone
def test_lag_and_delay_of_the_emulated_lab_are_found(folder, domain):
    lab = (*PATIENT_LAB, '--model', 'truth.yaml', '--nb-robots', '2', '--without-motion-check')
    ran = run_here('expe', '--algo', 'nav_wp', *lab, '--duration', '30', '--no-plots', '-o', 'lab')
    assert ran.returncode == 0, ran.stderr

    assert main(['identify', 'lab', '-o', 'found.yaml']) == 0

    until_the_next_step = 0.5 / LAB_RATE_HZ  # on average
    assert_found('found.yaml', latency=LATENCY_S + until_the_next_step)
    for name, options in (('near', ['--model', 'found.yaml']), ('far', ['--model', 'burger'])):
        assert main(['offline', '--from', 'lab', *options, '--no-plots', '-o', name]) == 0
    lab = Run.load('lab')
    near, far = (max(best_shift(lab, Run.load(name)).rms.values()) for name in ('near', 'far'))
    assert near < 0.5 * far


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['seen', '-o', 'model.csv'], "--output is 'model.csv'; it must end in .yaml or .yml"),
        (['seen', '-o', 'truth.yaml'], "'truth.yaml' already exists; choose another name"),
        (['nowhere'], "'nowhere'"),
        (['seen/csv/fleet.csv'], 'has no robot with both commands and motion'),
    ],
)
def test_a_mistake_is_reported_in_one_line(folder, arguments, message):
    simulate('nav_wp', 1, 3.0).save('seen')

    refuses('identify', *arguments, message=message, cwd=folder)
