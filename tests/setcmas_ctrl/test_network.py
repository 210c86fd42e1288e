import numpy as np
import pytest

from setcmas_ctrl import network
from setcmas_ctrl.communication.graph import path, star
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.script_errors import ControlError, ErrorReports

POSES = np.zeros((3, 4))


def law(tmp_path, body, robot=2):
    script = tmp_path / 'law.py'
    script.write_text(
        'import numpy as np\nfrom setcmas_ctrl import network\n'
        f'def control(robotNo, nbRobots, poses, t):\n    {body}\n'
    )
    return ControlLaw(script, robot, 4)


def test_each_robot_asks_for_itself(tmp_path):
    body = 'return len(network.neighbours()), network.neighbours()[0]'
    laws = [law(tmp_path, body, robot) for robot in (1, 2, 4)]

    assert [each(POSES, 0.0, star(4)) for each in laws] == [(3, 2), (1, 1), (1, 1)]
    assert [each(POSES, 0.0, path(4)) for each in laws] == [(1, 2), (2, 1), (1, 3)]


def test_matrices(tmp_path):
    body = 'return network.adjacency()[0, 1], network.laplacian()[1, 1]'

    assert law(tmp_path, body)(POSES, 0.0, 0.5 * path(4)) == (0.5, 1.0)


def test_without_a_graph_all_are_neighbours(tmp_path):
    body = 'return len(network.neighbours()), network.adjacency().sum()'

    assert law(tmp_path, body)(POSES, 0.0) == (3, 12)


def test_scripts_cannot_change_the_graph_of_the_others(tmp_path):
    with pytest.raises(ControlError, match='read-only'):
        law(tmp_path, 'network.adjacency()[:] = 0')(POSES, 0.0)


def test_nothing_is_answered_between_calls(tmp_path):
    failing = law(tmp_path, '1 / 0')
    with pytest.raises(ControlError):
        failing(POSES, 0.0)

    for question in (network.neighbours, network.adjacency, network.laplacian):
        with pytest.raises(RuntimeError, match='only while setcmas calls control'):
            question()


def test_a_law_that_uses_unknown_poses_gets_a_message(tmp_path):
    known = np.where(path(4)[1] + np.eye(4)[1] > 0, 0.0, np.nan) + POSES
    said = []
    reports = ErrorReports(said.append)
    with pytest.raises(ControlError) as error:
        law(tmp_path, 'return poses[0].mean(), 0')(known, 0.0, path(4))
    reports.failed(2, 0.0, error.value)

    assert 'control returned a value that is not finite' in said[0]
    assert 'tb3_2 receives nothing from robot 4: poses has NaN there' in said[0]
    assert 'network.neighbours()' in said[0]
    assert 'tb3_2 gets zero velocity' in said[0]


def test_other_failures_say_nothing_of_the_network(tmp_path):
    with pytest.raises(ControlError) as error:
        law(tmp_path, 'return 1 / 0 * poses')(np.full((3, 4), np.nan), 0.0)
    assert 'receives' not in str(error.value)
    with pytest.raises(ControlError) as error:
        law(tmp_path, 'return np.inf, 0')(POSES, 0.0)
    assert 'receives' not in str(error.value)
