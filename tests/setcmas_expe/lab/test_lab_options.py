import argparse

import pytest

from setcmas_expe.lab.lab_options import LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import take_values
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import ROBOT_LIMITS


def parsed(*arguments):
    parser = argparse.ArgumentParser()
    LabOptions.add_to(parser)
    take_values(parser)
    return LabOptions.of(parser.parse_args(arguments))


def test_what_options_say_goes_before_the_lab_file():
    lab = parsed(
        '--nb-robots=3',
        '--mocap=vicon',
        '--limits=waffle',
        '--arena=-2,2.5,-1,1',
        '--min-separation=0.4',
        '--accel=0.5',
    ).chosen()

    assert lab.nb_robots == 3
    assert lab.mocap.preset == 'vicon'
    assert lab.limits == ROBOT_LIMITS['waffle']
    assert lab.arena == Arena(-2, 2.5, -1, 1)
    assert (lab.min_separation, lab.accel) == (0.4, 0.5)


def test_a_process_gets_the_same_lab():
    options = parsed('--arena=-2.25,2,-0.1,1', '--nb-robots', '2')

    assert parsed(*options.arguments()) == options


@pytest.mark.parametrize(
    'arena', ['', '1,2,3', '0,1,0,x', '1,0,0,1', '0,1,0,0', '0,inf,0,1', '0,1,0,1,2']
)
def test_an_arena_without_a_size_is_a_mistake(arena, capsys):
    with pytest.raises(SystemExit):
        parsed(f'--arena={arena}')

    assert f"--arena is '{arena}'; it must be XMIN,XMAX,YMIN,YMAX" in capsys.readouterr().err


def test_a_lidar_stop_needs_the_guards(tmp_path):
    lab = tmp_path / 'lab.yaml'
    lab.write_text('safety: {lidar_stop: true}\n')

    assert LabOptions(lab=lab).chosen().lidar_stop
    with pytest.raises(SetcmasError, match='--without-guard: the lab file sets lidar_stop'):
        LabOptions(lab=lab, without_guard=True).chosen()
