"""The node of a controller by itself: a peer sends poses, and hears the velocities of the law."""

import math
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

import rclpy
from geometry_msgs.msg import Point32
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from stepped_alone import SteppedAlone

from setcmas_ctrl.communication.communication_options import chosen_communication
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.controller import Controller
from setcmas_ctrl.fleet_network import FleetNetwork
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.control_options import LawOptions
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_simu.reports import connected_launcher


class Controlled:
    """Robot 2 of two robots, its controller, and what that needs of its process."""

    def __init__(self, peer, script, *given, in_experiment=False):
        words = [word for one in given for word in ('-p', one)]
        self.peer, self.stepped, self.said = peer, SteppedAlone(0.25), []
        of_node = self.stepped.arguments(peer, '-r', '__ns:=/tb3_2', *words)
        options = LawOptions(algo=script)
        self.node = node = peer.add(Controller(None, options, in_experiment, **of_node))
        sources = {1: (node, '/tb3_1/odom'), 2: (node, node.odom_topic)}
        self.poses = FleetPoses(sources, 2)
        self.watch = CallWatch(self.said.append, connected_launcher({}))
        peer.ends.callback(self.watch.close)
        law = ControlLaw(Path(script), 2, 2)
        node.law = law
        node.network = FleetNetwork(node, self.poses, chosen_communication(2), [2])
        node.watch, node.reports = self.watch, ErrorReports(self.said.append)
        self.stepped.nodes = [self, node]
        names = [self.poses.topic_of(robot) for robot in (1, 2)]
        self.odometry = [peer.publisher(Odometry, name) for name in names]
        self.wanted = peer.listen(Point32, '/tb3_2/cmd_cart_vel')

    def step(self):
        """Take what came, before the node is stepped."""
        self.poses.take(self.stepped.clock.t)
        self.stepped.time.t = self.stepped.clock.t
        self.node.network.begin_step(self.stepped.clock.t)

    def place(self, robot, x, y=0.0):
        message = Odometry()
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        self.odometry[robot - 1].publish(message)

    def velocity(self):
        """Step once, and return what is wanted."""
        seen = len(self.wanted)
        self.stepped.step()
        self.peer.take_all()
        assert len(self.wanted) > seen
        return self.wanted[-1].x, self.wanted[-1].y


@pytest.fixture
def controlled(peer, script, monkeypatch):
    monkeypatch.setattr(rclpy, 'ok', lambda: True)  # the peer has a context of its own

    def create(body, *given, **kwargs):
        path = script(f'def control(robotNo, nbRobots, poses, t):\n    {body}\n')
        return Controlled(peer, path, *given, **kwargs)

    return create


def test_the_law_of_the_robot_is_called_with_all_poses_and_the_time(controlled):
    robot = controlled('return poses[0, 0] + robotNo / 8 + nbRobots, poses[1, 1] + t', 'vnom:=9.0')
    robot.place(1, 0.5)
    robot.place(2, 0.0, 1.0)

    assert robot.velocity() == (0.5 + 2 / 8 + 2, 1.0 + 0.25)
    robot.place(1, 1.0)
    assert robot.velocity() == (1.0 + 2 / 8 + 2, 1.0 + 0.5)


def test_velocities_are_at_most_vnom_which_can_be_set_for_each_robot(controlled):
    robot = controlled('return 0.0, -30.0', 'vnom:=0.25')
    assert robot.velocity() == (0.0, -0.25)
    (answer,) = robot.node.set_parameters([Parameter('vnom', value=2.0)])
    assert answer.successful
    assert robot.velocity() == (0.0, -2.0)

    (answer,) = robot.node.set_parameters([Parameter('vnom', value=0.0)])
    assert 'vnom is 0; it must be' in answer.reason


@pytest.mark.parametrize('in_experiment', [False, True])
def test_a_law_that_fails_commands_zero_and_is_named_once(controlled, in_experiment):
    body = 'return 0.25 / (t >= 1.25), 0.0'
    robot = controlled(body, in_experiment=in_experiment)
    failing = [robot.velocity() for _ in range(4)]

    if in_experiment:  # nothing, so that the bridge stops the robot for good
        assert all(math.isnan(vx) and math.isnan(vy) for vx, vy in failing)
    else:
        assert failing == [(0.0, 0.0)] * 4
    assert len(robot.said) == 1
    assert 'tb3_2 at t = 0.2 s: law.py, line 2: ZeroDivisionError' in robot.said[0]
    assert robot.velocity() == (0.25, 0.0)
    assert robot.node.reports.failed_robots == [2]


def test_in_a_pause_the_law_is_not_called_and_the_robot_rests(controlled):
    robot = controlled('print("called"); return 0.25, 0.0')
    robot.node.is_paused = True
    assert robot.velocity() == (0.0, 0.0)
    robot.node.is_paused = False
    assert robot.velocity() == (0.25, 0.0)


@pytest.mark.parametrize('why', ['is lost', 'no law'])
def test_without_a_pose_or_a_law_the_robot_rests(controlled, capsys, why):
    robot = controlled('print("called"); return 0.25, 0.0')
    if why == 'is lost':
        robot.node.is_lost = True
    else:
        robot.node.law = None

    assert robot.velocity() == (0.0, 0.0)
    assert 'called' not in capsys.readouterr().out


def test_the_poses_of_an_experiment_are_those_of_motion_capture(controlled):
    robot = controlled('return 0.25, 0.0', in_experiment=True)
    assert robot.poses.topic_of(2) == '/mocap/tb3_2/odom'

    robot = controlled('return poses[0, 1], 0.0', 'odom_topic:=pose')
    robot.place(2, 0.25)
    assert robot.poses.topic_of(2) == '/tb3_2/pose'
    assert robot.velocity() == (0.25, 0.0)
