"""Every decision about real robots, and sweeps that look for one that would be wrong."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_expe.safety.bridge_decision import HOLD_S, Situation, State, decide
from setcmas_simu.robots.arena import Arena, Obstacles

LAB = replace(load_lab(DEFAULT_FILE, 3), arena=Arena(-2.0, 2.0, -1.0, 1.0))
FREE = Situation(
    pose=(0.0, 0.0, 0.0),
    pose_age=0.01,
    pose_fault='',
    V=0.1,
    omega=0.2,
    command_age=0.1,
    paused='',
    rival='',
    fault='',
    unseen=(),
    others={2: (1.5, 0.5, 0.0), 3: (-1.5, 0.5, 0.0)},
)
RNG = np.random.default_rng(6)


def decision(**changes):
    return decide(replace(FREE, **changes), LAB)


def test_a_robot_stands_that_is_inside_an_obstacle():
    lab = replace(LAB, obstacles=Obstacles.of('disc 0 0.3 0.2; polygon 1 0 2 0 2 1'))

    result = decide(replace(FREE, pose=(0.0, 0.2, 0.0)), lab)

    assert (result.V, result.omega, result.lasting) == (0.0, 0.0, True)
    assert result.reason == 'inside an obstacle of the lab; carry it out'
    assert decide(FREE, lab).state is State.MOVING


def test_a_robot_that_nothing_speaks_against_gets_its_command():
    result = decision()

    assert (result.V, result.omega) == (0.1, 0.2)
    assert (result.state, result.reason, result.lost) == (State.MOVING, '', False)


@pytest.mark.parametrize(
    ('changes', 'state', 'reason', 'lost'),
    [
        ({'paused': 'paused'}, State.PAUSED, 'paused', False),
        ({'paused': 'paused', 'pose': None}, State.PAUSED, 'paused; not seen yet', True),
        ({'paused': 'paused', 'command_age': math.inf}, State.PAUSED, 'paused; no command', False),
        ({'unseen': (2, 3)}, State.STOPPED, 'robots 2-3 have not been seen yet', False),
        ({'rival': '/joy also commands it'}, State.STOPPED, '/joy also commands it', False),
        ({'fault': 'its wheels stand'}, State.STOPPED, 'its wheels stand', False),
        ({'pose': None, 'unseen': (1,)}, State.STOPPED, 'not seen yet', True),
        ({'pose': None}, State.STOPPED, 'not seen yet', True),
        ({'pose_fault': 'frozen'}, State.STOPPED, 'pose rejected: frozen', True),
        ({'pose_age': 0.51}, State.STOPPED, 'no good pose for 0.5 s', True),
        ({'pose_age': math.inf}, State.STOPPED, 'no good pose', True),
        ({'pose_age': math.nan}, State.STOPPED, 'no good pose', True),
        ({'command_age': 0.51}, State.STOPPED, 'no command for 0.5 s', False),
        ({'command_age': math.nan}, State.STOPPED, 'no command', False),
        ({'V': math.nan}, State.STOPPED, 'not a number', False),
        ({'omega': math.inf}, State.STOPPED, 'not a number', False),
    ],
)
def test_whatever_is_missing_stops_a_robot(changes, state, reason, lost):
    result = decision(**changes)

    assert (result.V, result.omega) == (0.0, 0.0)
    assert (result.state, result.lost) == (state, lost)
    assert result.lasting == (state is State.STOPPED)
    assert reason in result.reason


def test_every_combination_of_what_is_missing_is_zero():
    bad = [
        {'paused': 'paused'},
        {'unseen': (2,)},
        {'rival': 'several robots listen'},
        {'fault': 'its guard is silent'},
        {'pose_fault': 'jumped'},
        {'pose_age': 3.0},
        {'command_age': 3.0},
        {'V': math.nan},
    ]
    for size in range(1, len(bad) + 1):
        for chosen in itertools.combinations(bad, size):
            changes = {key: value for part in chosen for key, value in part.items()}
            result = decision(**changes)
            assert (result.V, result.omega) == (0.0, 0.0), changes


def test_just_in_time_is_in_time():
    assert decision(pose_age=0.44, command_age=0.49).state == State.MOVING


@pytest.mark.parametrize(
    ('pose', 'V', 'goes'),
    [
        ((2.1, 0.0, 0.0), 0.1, False),  # outside to the right, ahead leads further out
        ((2.1, 0.0, 0.0), -0.1, True),  # backwards leads in
        ((2.1, 0.0, math.pi), 0.1, True),
        ((-2.1, 0.0, 0.3), 0.1, True),
        ((-2.1, 0.0, 2.0), 0.1, False),
        ((0.0, 1.1, -1.5), 0.1, True),
        ((0.0, -1.1, -1.5), 0.1, False),
        ((2.1, 1.1, -2.3), 0.1, True),  # beyond a corner: both sides count
        ((2.1, 1.1, 2.3), 0.1, False),
        ((2.0, 1.0, 0.0), 0.1, True),  # on the border is inside
    ],
)
def test_outside_the_arena_only_motion_back_inside_is_let_through(pose, V, goes):
    result = decision(pose=pose, V=V, omega=0.0, others={})

    assert decision(pose=pose, V=V, omega=1.0, others={}).omega == 1.0  # it may turn
    assert (V if goes else 0.0) == result.V
    assert result.state == (State.MOVING if goes else State.STOPPED)
    assert ('outside' in result.reason) == (pose[:2] != (2.0, 1.0))


def places_over_a_hold(pose, V, omega):
    """Return the places of a unicycle that holds a command as long as it can."""
    for t in np.linspace(0.0, HOLD_S, 31):
        heading = pose[2] + omega * t
        if abs(omega) < 1e-9:
            dx, dy = V * t * math.cos(pose[2]), V * t * math.sin(pose[2])
        else:
            dx = V / omega * (math.sin(heading) - math.sin(pose[2]))
            dy = V / omega * (math.cos(pose[2]) - math.cos(heading))
        yield pose[0] + dx, pose[1] + dy


def test_no_command_ever_leads_further_out_of_the_arena():
    let_through = 0
    for _ in range(4000):
        pose = (*RNG.uniform(-1.0, 1.0, 2) * (3.0, 2.0), RNG.uniform(-7, 7))
        if not LAB.arena.outward_normals(*pose[:2]):
            continue
        V, omega = RNG.uniform(-0.5, 0.5), RNG.uniform(-8, 8)
        result = decision(pose=pose, V=V, omega=omega, others={})
        let_through += result.V != 0.0
        for normal in LAB.arena.outward_normals(*pose[:2]):
            out = [
                x * normal[0] + y * normal[1]
                for x, y in places_over_a_hold(pose, result.V, result.omega)
            ]
            assert np.diff(out).max() <= 1e-12, (pose, V, omega)
    assert let_through > 500


def test_no_command_ever_leads_nearer_to_a_robot_that_is_too_near():
    let_through = 0
    for _ in range(4000):
        pose = (0.0, 0.0, RNG.uniform(-7, 7))
        angle, distance = RNG.uniform(-math.pi, math.pi), RNG.uniform(1e-6, 0.349)
        other = (distance * math.cos(angle), distance * math.sin(angle), 0.0)
        V, omega = RNG.uniform(-0.5, 0.5), RNG.uniform(-8, 8)
        result = decision(pose=pose, V=V, omega=omega, others={2: other})
        let_through += result.V != 0.0
        distances = [
            math.dist(place, other[:2])
            for place in places_over_a_hold(pose, result.V, result.omega)
        ]
        assert np.diff(distances).min() >= -1e-12, (pose, other, V, omega)
    assert let_through > 500


def test_no_command_is_ever_beyond_the_limits():
    for V, omega in RNG.uniform(-1, 1, (2000, 2)) * (2.0, 20.0):
        result = decision(V=V, omega=omega)
        wheel = abs(result.V) + 0.5 * LAB.limits.wheel_separation * abs(result.omega)
        assert abs(result.V) <= LAB.limits.V_max + 1e-12
        assert abs(result.omega) <= LAB.limits.omega_max + 1e-12
        assert wheel <= LAB.limits.wheel_speed_max + 1e-12
        assert result.V * omega == pytest.approx(result.omega * V)


def test_too_near_says_to_whom_and_counts_the_edge_as_far_enough():
    near = decision(others={2: (0.3, 0.0, 0.0), 3: (0.0, 0.2, 0.0)})
    edge = decision(others={2: (LAB.min_separation, 0.0, 0.0)})

    assert near.state == State.STOPPED
    assert 'closer than 0.35 m to robots 2-3; it may only move away' in near.reason
    assert edge.state == State.MOVING


def test_robots_at_one_place_stand():
    assert decision(others={2: FREE.pose}).V == 0.0
    assert decision(others={2: FREE.pose}, V=-0.1).V == 0.0


def test_two_robots_on_collision_course_stop_and_can_part_again():
    poses = {1: (-0.5, 0.0, 0.0), 2: (0.5, 0.0, math.pi)}

    def drive(speed, steps):
        for _ in range(steps):
            moved = {}
            for robot, other in ((1, 2), (2, 1)):
                x, y, theta = poses[robot]
                result = decide(
                    replace(FREE, pose=poses[robot], V=speed, omega=0.0,
                            others={other: poses[other]}), LAB
                )  # fmt: skip
                moved[robot] = (x + 0.05 * result.V * math.cos(theta), y, theta)
            poses.update(moved)
        return math.dist(poses[1][:2], poses[2][:2])

    assert 0.32 < drive(0.2, 200) < LAB.min_separation
    assert drive(-0.2, 50) > 1.0
