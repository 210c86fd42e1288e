import numpy as np
import pytest

from setcmas_ctrl import network
from setcmas_ctrl.communication.graph import path, star
from setcmas_ctrl.communication.message_content import Content
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports

POSES = np.zeros((3, 4))


def law(tmp_path, body, robot=2):
    """Return a law that asks the network when it is called."""
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


def test_nothing_is_answered_between_calls(tmp_path):
    failing = law(tmp_path, '1 / 0')
    with pytest.raises(ControlError):
        failing(POSES, 0.0)

    for question in (
        network.neighbours,
        network.adjacency,
        network.laplacian,
        network.received,
        lambda: network.send(1),
    ):
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


class Exchange:
    """Delivers everything to all robots at once."""

    t = 1.0

    def __init__(self):
        self.contents = {}

    def begin(self):
        pass

    def send(self, robot, value):
        self.contents[robot] = Content(self.t, value)

    def received(self, robot):
        return {sender: one for sender, one in self.contents.items() if sender != robot}


def test_messages_have_values_ages_and_times(tmp_path):
    exchange = Exchange()
    asking = 'm = network.received()[1]; return m.value["x"], m.age + 10 * m.t'
    with network.exchanged_by(exchange):
        law(tmp_path, 'network.send(0); network.send({"x": 7}); return 0, 0', 1)(POSES, 1.0)
        exchange.t = 1.3

        assert law(tmp_path, asking, 2)(POSES, 1.3) == (7.0, 10.3)
        assert law(tmp_path, 'return len(network.received()), 0', 1)(POSES, 1.3) == (0, 0)


def test_what_cannot_be_sent_is_an_error_in_the_line_of_the_script(tmp_path):
    exchange = Exchange()
    with network.exchanged_by(exchange), pytest.raises(ControlError) as error:
        law(tmp_path, 'network.send("hello"); return 0, 0')(POSES, 0.0)

    assert str(error.value).startswith(
        "law.py, line 4: TypeError: network.send got 'hello'; it must be a finite number"
    )
    assert exchange.contents == {}


def test_a_call_that_fails_later_has_sent_its_message(tmp_path):
    exchange = Exchange()
    with network.exchanged_by(exchange), pytest.raises(ControlError):
        law(tmp_path, 'network.send(3); return 1 / 0, 0')(POSES, 0.0)

    assert exchange.contents[2].value == 3.0


def test_without_a_run_messages_go_nowhere(tmp_path):
    assert law(tmp_path, 'network.send(3); return len(network.received()), 0')(POSES, 0.0) == (
        0,
        0,
    )
