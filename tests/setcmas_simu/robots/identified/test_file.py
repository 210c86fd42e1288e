import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.identified.file import (
    ModelFile,
    read_model_file,
    write_model_file,
)
from setcmas_simu.robots.identified.model import IdentifiedRobot, Response
from setcmas_simu.robots.models import check_models, fastest, robot_models
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS

SLOW = Response(0.9, 0.15, 0.2)
QUICK = Response(1.05, 0.0, 0.1)


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'model.yaml'


def test_what_is_written_is_read(path):
    burger = ROBOT_MODELS['burger']
    robot = IdentifiedRobot(SLOW, QUICK, burger, 0.06)
    write_model_file(ModelFile({2: robot}, None, 'burger'), path, 'of a test')

    read = read_model_file(path).robot(2)

    assert (read.forward, read.turn, read.limits, read.way) == (SLOW, QUICK, burger, 0.06)
    assert path.read_text().startswith('# of a test\n')


def test_robots_that_are_not_named_are_the_others(path):
    path.write_text('robots:\n  1: {forward: {lag: 0.3}}\nothers: {turn: {delay: 0.1}}\n')

    assert read_model_file(path).robot(1).forward == Response(lag=0.3)
    seventh, eighth = robot_models([str(path)] * 2, [7, 8])
    assert seventh.turn == Response(delay=0.1)
    assert eighth is seventh


def test_each_robot_of_a_fleet_has_its_own(path):
    path.write_text('limits: burger\nrobots:\n  1: {forward: {lag: 0.3}}\n  3: {}\n')

    first, second, third = robot_models([str(path), 'burger', str(path)], [1, 2, 3])

    assert first.forward.lag == 0.3
    assert third.forward.lag == 0.0
    assert second.limits is first.limits
    assert fastest(f'1,3:{path}', 3, 'ideal') == float('inf')  # robot 2 is a unicycle
    with pytest.raises(SetcmasError, match='has no model of tb3_2, only of tb3_1, tb3_3'):
        check_models([str(path)] * 3, 'ideal')


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('robots: {1: {forward: {lag: -1}}}', 'line 1: robots.1.forward.lag is -1; it must be'),
        ('robots: {1: {forward: {gain: 0}}}', 'gain is 0; it must be a number above 0 up to 10'),
        ('robots: {1: {turn: {delay: 3}}}', 'delay is 3; it must be a number from 0 up to 2'),
        ('robots: {1: {speed: {}}}', "there is no key 'robots.1.speed'; it must be one of"),
        ('robots: {0: {}}', "invalid robot '0'; must be a whole number from 1"),
        ('robots: 3', 'robots is 3; it must be a mapping'),
        ('limits: fast\nothers: {}', "limits is 'fast'; it must be one of ideal, burger"),
        ('', "has no robots; add 'robots' or 'others'"),
        ('a: [', 'not YAML'),
    ],
)
def test_a_mistake_is_told_in_one_line(path, text, message):
    path.write_text(text)

    with pytest.raises(SetcmasError) as caught:
        read_model_file(path)
    assert message in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_file_that_is_not_there_is_told(path):
    with pytest.raises(SetcmasError, match=r"model.yaml' cannot be read: No such file"):
        check_models([str(path)], 'ideal')
