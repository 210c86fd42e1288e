import math

import numpy as np
import pytest

from setcmas_ctrl.filter.barrier_constraints import check_starts
from setcmas_ctrl.filter.filter_options import FilterOptions, Verdict
from setcmas_ctrl.laws.control_options import GainOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Obstacles
from setcmas_simu.robots.car import CAR
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.omnidirectional import OMNIDIRECTIONAL
from setcmas_simu.robots.unicycle import UNICYCLE, Unicycle
from setcmas_tools.offline.offline_fleet import Commander

TS = 0.2
BURGER = limits_named('burger')
CIRCLE = np.arange(6) * math.tau / 6


class Fleet:
    """Robots that want to goals."""

    def __init__(self, poses, goals, model=OMNIDIRECTIONAL, right_deg=0, **options):
        self.poses, self.goals, self.model = poses, goals, model
        cos, sin = math.cos(math.radians(right_deg)), math.sin(math.radians(right_deg))
        self.turn = np.array([[cos, sin], [-sin, cos]])
        self.messages = []
        nb_robots = poses.shape[1]
        filtered = FilterOptions(filter='barrier', **options)
        self.commander = Commander(GainOptions(), filtered, nb_robots, self.messages.append)
        self.commander.use([model] * nb_robots)

    def step(self):
        self.last = self.commander(self.turn @ (self.goals - self.poses[:2]), self.poses)
        self.poses = self.model.step(self.model.start(self.poses), self.last.commands, TS)[:3]

    def run(self, duration=20.0):
        """Return the smallest distance between two robots, and the way of each, (K, 2, N)."""
        ways = []
        for _ in range(round(duration / TS)):
            self.step()
            ways.append(self.poses[:2].copy())
        ways = np.array(ways)
        offsets = np.hypot(*(ways[:, :, :, None] - ways[:, :, None]).transpose(1, 0, 2, 3))
        i, j = np.triu_indices(ways.shape[2], 1)
        return offsets[:, i, j].min(initial=np.inf), ways


def swap(**options):
    start = np.vstack([1.5 * np.cos(CIRCLE), 1.5 * np.sin(CIRCLE), CIRCLE + math.pi])
    return Fleet(start, -start[:2], **options)


@pytest.mark.parametrize('model', [OMNIDIRECTIONAL, UNICYCLE])
def test_robots_that_change_places_never_come_nearer_than_wanted(model):
    least, _ = swap(model=model, min_separation=0.4).run()

    assert 0.4 <= least < 0.6


def test_robots_keep_the_distance_of_a_lab_where_poses_are_a_tenth_of_a_second_old():
    filtered = Commander(GainOptions(), FilterOptions(filter='barrier', gamma=5.0), 2)
    filtered.use([OMNIDIRECTIONAL] * 2)
    x, wanted = np.array([-2.0, 2.0]), np.array([[0.5, -0.5], [0.0, 0.0]])
    velocity, distances = np.zeros(2), []
    for _ in range(100):
        seen = np.array([x, 0 * x, 0 * x])
        x = x + 0.1 * velocity  # while the poses are on their way
        velocity = filtered(wanted, seen).allowed[0]
        x = x + 0.1 * velocity
        distances.append(x[1] - x[0])

    assert 0.35 <= min(distances) < 0.45


def test_robots_that_block_each_other_are_reported_once_and_stand():
    fleet = swap()
    fleet.run(20.0)

    (message,) = fleet.messages
    assert message.startswith('the safety filter keeps robots 1-6 stopped: other robots,')
    assert (fleet.last.allowed[2] == Verdict.CHANGED).all()


@pytest.mark.parametrize('model', [OMNIDIRECTIONAL, UNICYCLE])
def test_robots_whose_law_heads_to_the_right_of_its_goal_arrive(model):
    fleet = swap(model=model, right_deg=20)
    least, _ = fleet.run(30.0)

    assert least >= 0.35
    assert np.abs(fleet.poses[:2] - fleet.goals).max() < 0.1


def test_a_robot_with_free_way_is_commanded_as_without_a_filter_to_the_last_bit():
    poses = np.array([[0.0, 0.1, 4.0], [0.0, 0.4, 0.0], [0.0, -1.0, 2.0]])
    wanted = np.array([[0.1, 0.0, -0.2], [0.3, -0.3, 0.3]])
    on, off = (
        Commander(GainOptions(), FilterOptions(filter=name), 3) for name in ('barrier', 'none')
    )
    for commander in (on, off):
        commander.use([UNICYCLE] * 3)

    filtered, free = on(wanted, poses), off(wanted, poses)

    assert (filtered.commands[:, 2] == free.commands[:, 2]).all()
    assert filtered.allowed[2].tolist() == [Verdict.CHANGED, Verdict.CHANGED, Verdict.KEPT]
    assert (filtered.allowed[:2, 2] == filtered.wanted[:, 2]).all()


def test_commands_keep_the_limits_of_unicycles():
    poses = np.array([[0.0, 1.0], [0.0, 0.0], [0.0, math.pi]])
    wanted = np.array([[0.3, -0.3], [0.3, 0.3]])
    commander = Commander(GainOptions(), FilterOptions(filter='barrier'), 2)
    commander.use([Unicycle(BURGER)] * 2)

    assert np.abs(commander(wanted, poses).commands[0]).max() <= BURGER.V_max


def test_arena_and_obstacles_are_kept_off():
    start = np.array([[-1.5, -1.5], [0.6, -0.6], [0.0, 0.0]])
    text = 'disc 0 0.75 0.2; polygon 0 -0.2 0.5 -0.6 0 -1 0.2 -0.6'  # the polygon is not convex
    fleet = Fleet(
        start, np.array([[2.0, 2.0], [0.7, -0.6]]), arena=(-2, 1, -2, 2), obstacles=text,
        min_separation=0.3,
    )  # fmt: skip
    _, ways = fleet.run(30.0)

    assert ways[:, 0].max() <= 1.0
    disc = Obstacles.of(text).discs[0]
    assert np.hypot(ways[:, 0, 0] - disc.x, ways[:, 1, 0] - disc.y).min() >= disc.radius + 0.15
    corner = np.hypot(ways[:, 0, 1] - 0.0, ways[:, 1, 1] + 0.2).min()
    assert corner >= 0.15


def test_robots_that_start_too_near_go_apart():
    start = np.array([[0.0, 0.2], [0.0, 0.0], [0.0, 0.0]])
    fleet = Fleet(start, np.zeros((2, 2)))
    fleet.run(10.0)

    assert np.ptp(fleet.poses[0]) > 0.34


def test_unicycles_whose_points_have_passed_each_other_go_back():
    poses = np.array([[0.0, 0.08], [0.0, 0.0], [0.0, math.pi]])
    fleet = Fleet(poses, np.array([[3.0, -3.0], [0.0, 0.0]]), model=UNICYCLE)
    least, _ = fleet.run(30.0)

    assert least > 0.07  # they backed off, and then went round
    assert 'robots 1-2 start too close to others' in fleet.messages[0]


@pytest.mark.parametrize('model', [OMNIDIRECTIONAL, UNICYCLE])
def test_speeds_rise_slowly_where_the_filter_changes_commands_too(model):
    fleet = swap(model=model, accel=0.2)
    before = np.zeros(6)
    for _ in range(100):
        fleet.step()
        speeds = np.hypot(*fleet.last.commands[:2])
        assert (speeds - before).max() < 0.2 * TS + 0.04  # the turns'
        before = speeds
    assert (fleet.last.allowed[2] != Verdict.NO_SOLUTION).all()


def test_no_solution_means_zero():
    # In the middle of five others it can go nowhere, and must.
    others = 0.12 * np.array([np.cos(CIRCLE), np.sin(CIRCLE)])
    poses = np.vstack([np.hstack([others, np.zeros((2, 1))]), np.zeros(7)])
    fleet = Fleet(poses, np.zeros((2, 7)), arena=(-0.1, 0.1, -0.1, 0.1))
    fleet.step()

    assert (fleet.last.commands == 0.0).all()
    assert (fleet.last.allowed[2] == Verdict.NO_SOLUTION).all()


def test_a_car_is_refused():
    commander = Commander(GainOptions(), FilterOptions(filter='barrier'), 2)

    with pytest.raises(SetcmasError, match='robot 2 cannot'):
        commander.use([UNICYCLE, CAR])


@pytest.mark.parametrize(
    ('world', 'where'),
    [
        ({'arena': (-1, 3, -1, 1)}, 'outside the arena'),
        ({'obstacles': 'disc 2 1 0.5'}, 'inside an obstacle'),
        ({'obstacles': 'polygon 1 0 3 0 3 3 1 3'}, 'inside an obstacle'),
    ],
)
def test_robots_must_start_where_they_may_be(world, where):
    poses = np.array([[0.0, 2.0], [0.0, 1.2], [0.0, 0.0]])
    notch = FilterOptions(filter='barrier', obstacles='polygon 1 0 3 0 1.5 1 3 3 1 3')
    check_starts(notch, poses)
    check_starts(FilterOptions(**world), poses)

    with pytest.raises(SetcmasError, match=rf'robot 2 starts at \(2, 1\.2\) m, {where}'):
        check_starts(FilterOptions(filter='barrier', **world), poses)


def test_robots_must_start_as_far_apart_as_they_are_kept():
    poses = np.array([[0.0, 2.0, 2.0], [0.0, 0.0, 0.4], [0.0, 0.0, 0.0]])
    check_starts(FilterOptions(filter='barrier', min_separation=0.4), poses)
    check_starts(FilterOptions(min_separation=0.5), poses)

    with pytest.raises(SetcmasError, match=r'^robots 2 and 3 start 0\.4 m apart; .*least 0\.5 m'):
        check_starts(FilterOptions(filter='barrier', min_separation=0.5), poses)
