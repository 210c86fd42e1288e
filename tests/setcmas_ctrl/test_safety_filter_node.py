"""The safety filter's node: velocities of controllers in, what is allowed out, to si_to_uni."""

import math
from functools import partial

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point32, TwistStamped
from nav_msgs.msg import Odometry
from ros_peer import velocity
from stepped_alone import SteppedAlone

from setcmas_ctrl.filter.filter_options import FilterOptions, Verdict
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.control_options import ControllerOptions, GainOptions
from setcmas_ctrl.safety_filter_node import SafetyFilterNode
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.robots.model import IDEAL
from setcmas_simu.ros.fleet_node import FleetNode

OPTIONS = FilterOptions(filter='barrier', min_separation=0.4)


class Filtered:
    """Two robots that face each other, 1 m apart, at a control rate of 4 Hz."""

    def __init__(self, peer, in_experiment=False):
        self.peer, self.stepped = peer, SteppedAlone(0.25)
        gains, options = GainOptions(rate=4.0), ControllerOptions(experiment=in_experiment)
        fleet = peer.add(FleetNode('controllers', context=peer.context))
        of_node = {'fleet': fleet, 'time': self.stepped.time, 'context': peer.context}
        self.robots = robots = [
            peer.add(SiToUni(i, gains, OPTIONS, options, IDEAL, **of_node)) for i in (1, 2)
        ]
        self.poses = FleetPoses({one.robot: (one, one.odom_topic) for one in robots}, 2)
        for robot in robots:
            robot.poses = self.poses
        self.node = peer.add(SafetyFilterNode(fleet, robots, OPTIONS, gains, self.poses))
        self.stepped.nodes = [self, self.node, *robots]
        self._odometry = [peer.publisher(Odometry, self.poses.topic_of(i)) for i in (1, 2)]
        self._wanted = [peer.publisher(Point32, f'/tb3_{i}/cmd_cart_vel') for i in (1, 2)]
        self.allowed = [peer.listen(Point32, f'/tb3_{i}/cmd_cart_vel_allowed') for i in (1, 2)]
        self.commands = [peer.listen(TwistStamped, one.cmd_vel.topic) for one in robots]

    def step(self):
        """Send and take poses, before the nodes are stepped."""
        for publisher, x, turn in zip(self._odometry, (-0.5, 0.5), (0.0, 1.0), strict=True):
            message = Odometry()
            message.pose.pose.position.x = x
            message.pose.pose.orientation.z, message.pose.pose.orientation.w = turn, 1.0 - turn
            publisher.publish(message)
        self.poses.take(self.stepped.clock.t)

    def step_once(self):
        """Step; return how many messages that gave: what the robots may do, then commands."""
        given = (*self.allowed, *self.commands)
        before = [len(messages) for messages in given]
        self.stepped.step()
        self.peer.take_all()
        return [len(messages) - n for messages, n in zip(given, before, strict=True)]

    def after(self, *wanted):
        """Let these velocities along x be wanted, step once, and return what is allowed."""
        for publisher, vx in zip(self._wanted, wanted, strict=True):
            if vx is not None:
                publisher.publish(Point32(x=vx))
        assert self.step_once() == [1, 1, 1, 1]
        return [(one[-1].x, Verdict(int(one[-1].z))) for one in self.allowed]


@pytest.fixture
def filtered(peer):
    return partial(Filtered, peer)


def test_velocities_of_robots_far_from_each_other_are_kept(filtered):
    fleet = filtered()

    assert fleet.after(-0.25, 0.25) == [(-0.25, Verdict.KEPT), (0.25, Verdict.KEPT)]
    assert velocity(fleet.commands[0][-1]) == pytest.approx((0.25, 1.5 * math.pi), rel=1e-6)


def test_robots_that_would_collide_are_slowed_and_si_to_uni_obeys(filtered):
    fleet = filtered()
    (first, of_first), (second, of_second) = fleet.after(3.0, -3.0)

    assert of_first is of_second is Verdict.CHANGED
    assert 0.0 < first < 0.5
    assert first == pytest.approx(-second)
    assert velocity(fleet.commands[0][-1]) == pytest.approx((first, 0.0), abs=1e-6)


def test_a_robot_that_is_not_heard_any_more_counts_as_standing(filtered):
    fleet = filtered()
    fleet.after(-0.25, 0.25)
    later = [fleet.after(-0.25, None) for _ in range(6)]  # 1.5 s

    assert [allowed[1][0] for allowed in later] == [0.25] * 4 + [0.0] * 2
    assert {allowed[0][0] for allowed in later} == {-0.25}
    fleet.after(-0.25, None)
    fleet.after(-0.25, None)
    fleet._wanted[0].publish(Point32(x=-0.25))

    allowed, commands = fleet.step_once()[1::2]
    assert allowed == 0  # the robot is left to others
    assert commands == 1  # the last zeros of si_to_uni


def test_in_an_experiment_silence_of_a_law_reaches_the_bridge_at_once(filtered):
    fleet = filtered(in_experiment=True)
    fleet.after(-0.25, 0.25)
    fleet._wanted[0].publish(Point32(x=-0.25))

    assert fleet.step_once()[2:] == [1, 0]


@pytest.mark.parametrize('vx', [math.nan, math.inf])
@pytest.mark.parametrize('in_experiment', [False, True])
def test_a_velocity_that_is_no_number_stops_its_robot_only(filtered, vx, in_experiment):
    fleet = filtered(in_experiment=in_experiment)
    _, (second, verdict) = fleet.after(vx, 0.25)

    assert math.isnan(fleet.allowed[0][-1].x)
    assert (second, verdict) == (0.25, Verdict.KEPT)
    V, _ = velocity(fleet.commands[0][-1])
    assert math.isnan(V) if in_experiment else V == 0.0
    assert velocity(fleet.commands[1][-1])[0] == pytest.approx(0.25)


def test_without_new_velocities_it_says_nothing(filtered):
    fleet = filtered()
    fleet.after(-0.25, 0.25)

    assert [fleet.step_once()[:2] for _ in range(3)] == [[0, 0]] * 3


def test_its_last_word_is_zero(peer, filtered):
    fleet = filtered()
    fleet.after(-0.25, 0.25)
    fleet.node.stop()
    peer.take_all()

    assert [one[-1].x for one in fleet.allowed] == [0.0, 0.0]
