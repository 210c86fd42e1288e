"""The node si_to_uni by itself: a peer sends velocities and odometry, and hears the commands."""

import math
from functools import partial

import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from ros_peer import velocity
from std_msgs.msg import Bool
from stepped_alone import SteppedAlone

from setcmas_ctrl.filter.filter_options import FilterOptions, Verdict
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.control_options import ControllerOptions, GainOptions
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.robots.model import IDEAL

PERIOD_S = 0.05


class Driven:
    """Robot 3 with its node; it stands at a heading of 0, and its odometry comes at each step."""

    def __init__(self, peer, *given, gains=None, safety=None, odom='/tb3_3/odom', **options):
        words = [word for one in given for word in ('-p', one)]
        self.peer, self.stepped = peer, SteppedAlone(PERIOD_S)
        self.node = peer.add(
            SiToUni(
                None,
                gains or GainOptions(),
                safety or FilterOptions(),
                ControllerOptions(**options),
                IDEAL,
                **self.stepped.arguments(peer, '-r', '__ns:=/tb3_3', *words),
            )
        )
        self.poses = FleetPoses({3: (self.node, self.node.odom_topic)}, 3)
        self.node.poses = self.poses
        self.stepped.nodes = [self, self.node]
        self.has_odometry = True
        self._odometry = peer.publisher(Odometry, odom)
        self.commands = peer.listen(TwistStamped, self.node.cmd_vel.topic)

    def step(self):
        """Take poses, before the node is stepped."""
        if self.has_odometry:
            self._odometry.publish(Odometry())
        self.poses.take(self.stepped.clock.t)

    def steps(self, seconds=PERIOD_S):
        """Step for a time; return the new commands."""
        before = len(self.commands)
        self.stepped.step(round(seconds / PERIOD_S))
        self.peer.take_all()
        return [velocity(command) for command in self.commands[before:]]

    def set(self, name, value):
        (answer,) = self.node.set_parameters([Parameter(name, value=value)])
        return answer.reason


@pytest.fixture
def driven(peer):
    return partial(Driven, peer)


@pytest.fixture
def send(peer):
    """Send a velocity as any program may: ros2 topic pub, or a controller in another language."""
    publishers = {}

    def send(x, y=0.0, z=0.0, topic='/tb3_3/cmd_cart_vel'):
        if topic not in publishers:
            publishers[topic] = peer.publisher(Point32, topic)
        publishers[topic].publish(Point32(x=x, y=y, z=z))

    return send


def test_whoever_publishes_a_velocity_drives_the_robot(driven, send):
    robot = driven('komega:=2.0')
    assert robot.steps(1.0) == []  # nothing is said before the first velocity
    send(0.0, 0.25)

    assert robot.steps() == [pytest.approx((0.25, 2.0 * math.pi / 2))]
    assert robot.set('komega', 1.0) == ''
    send(0.0, 0.25)
    assert robot.steps() == [pytest.approx((0.25, math.pi / 2))]
    assert 'komega is 0; it must be' in robot.set('komega', 0.0)


def test_a_command_is_repeated_at_5_hz_until_velocities_have_been_silent_for_too_long(
    driven, send
):
    robot = driven()
    send(0.5)
    assert robot.steps(1.0) == [(0.5, 0.0)] * 5
    robot.steps(0.25)  # 1 s is over in between
    assert {*robot.steps(1.0)} == {(0.0, 0.0)}
    robot.steps(0.25)
    assert robot.steps(1.0) == []  # others may drive the robot now

    send(0.25)
    assert robot.steps(0.2) == [(0.25, 0.0)]


def test_between_the_steps_of_its_law_a_robot_takes_no_velocity_of_others(driven, send):
    robot = driven()
    send(0.5)
    robot.node.repeat()
    robot.peer.wait_for(lambda: robot.node.velocity() is not None)  # it was left

    assert not robot.commands


def test_in_an_experiment_nothing_is_repeated_as_silence_stops_the_robot(driven, send):
    robot = driven(experiment=True, odom='/mocap/tb3_3/odom')
    send(0.5)
    assert robot.steps(0.2) == [(0.5, 0.0)]

    assert robot.steps(1.0) == []
    assert not robot.node.pause_request  # nor does a message resume the robot


@pytest.mark.parametrize(
    ('rate', 'given', 'timeout'), [(5.0, (), 1.0), (0.5, (), 6.0), (5.0, ('cmd_timeout:=2',), 2.0)]
)
def test_slow_controllers_are_waited_for_longer(driven, send, rate, given, timeout):
    robot = driven(*given, gains=GainOptions(rate=rate))
    assert robot.node.timeout == timeout
    send(0.5)

    assert {*robot.steps(timeout)} == {(0.5, 0.0)}
    assert robot.steps(0.5)[-1] == (0.0, 0.0)


def test_a_pause_holds_the_robot_whatever_comes_until_it_is_resumed(peer, driven, send):
    robot = driven()
    pause = peer.publisher(Bool, '/tb3_3/pause')
    send(0.5)
    robot.steps()
    pause.publish(Bool(data=True))
    assert robot.steps() == [(0.0, 0.0)]
    send(0.25)
    assert {*robot.steps(0.5)} == {(0.0, 0.0)}

    pause.publish(Bool(data=False))
    send(0.25)
    assert robot.steps()[-1] == (0.25, 0.0)
    robot.node.stopped = True  # an emergency
    robot.node.pause(True)
    pause.publish(Bool(data=False))
    send(0.25)
    assert {*robot.steps(0.5)} == {(0.0, 0.0)}


def test_a_robot_whose_pose_is_unknown_or_too_old_rests(driven, send):
    robot = driven()
    robot.has_odometry = False
    send(0.5)
    assert robot.steps() == [(0.0, 0.0)]
    robot.has_odometry = True
    robot.steps()
    send(0.5)
    assert robot.steps() == [(0.5, 0.0)]

    robot.has_odometry = False
    robot.steps(1.2)
    send(0.5)
    assert robot.steps() == [(0.0, 0.0)]


def test_with_the_filter_it_follows_what_that_allows_and_its_verdicts(driven, send):
    robot = driven(safety=FilterOptions(filter='barrier'))
    allowed = '/tb3_3/cmd_cart_vel_allowed'
    send(0.0, 0.25, float(Verdict.KEPT), allowed)
    assert robot.steps() == [pytest.approx((0.25, 1.5 * math.pi / 2))]
    send(0.0, 0.25, float(Verdict.CHANGED), allowed)
    ((V, omega),) = robot.steps()
    assert abs(V) < 0.15  # the point ahead moves by turning
    assert omega > 1.0

    send(0.25, 0.0, math.nan, allowed)  # not from the filter
    assert robot.steps() == [(0.0, 0.0)]


def test_topics_can_be_others(driven, send):
    robot = driven(
        'velocity_topic:=wanted', 'cmd_vel_topic:=/drive', 'odom_topic:=pose', odom='/tb3_3/pose'
    )
    assert robot.node.cmd_vel.topic == '/drive'
    send(0.25, topic='/tb3_3/wanted')

    assert robot.steps() == [(0.25, 0.0)]


def test_speed_rises_from_rest_after_a_silence(driven, send):
    robot = driven(safety=FilterOptions(accel=0.5))
    speeds = []
    for _ in range(6):
        send(0.5)
        speeds += [V for V, _ in robot.steps(0.2)][:1]
    assert speeds == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.5])
    assert robot.steps(1.5)[-1] == (0.0, 0.0)
    send(0.5)

    assert robot.steps() == [pytest.approx((0.1, 0.0))]


def test_in_an_experiment_a_law_that_fails_or_knows_no_pose_becomes_no_command(driven, send):
    robot = driven(experiment=True, odom='/mocap/tb3_3/odom')
    assert robot.node.cmd_vel.topic == '/tb3_3/cmd_vel_wanted'
    send(math.nan, math.nan)
    assert np.isnan(robot.steps()).all()

    robot.has_odometry = False  # of it the bridge must know, too
    robot.steps(1.2)
    send(0.5)
    assert np.isnan(robot.steps()).all()


def test_its_last_word_is_zero(peer, driven, send):
    robot = driven()
    send(0.5)
    robot.steps()
    robot.node.stop()
    peer.take_all()

    assert velocity(robot.commands[-1]) == (0.0, 0.0)
