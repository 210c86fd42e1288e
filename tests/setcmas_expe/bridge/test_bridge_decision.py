"""Every decision about real robots, and sweeps that look for one that would be wrong."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.bridge.bridge_decision import (
    HOLD_S,
    BridgeState,
    Cause,
    FleetView,
    RobotView,
    StopReason,
    decide,
)
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_simu.robots.arena import Arena, Obstacles

LAB = replace(load_lab(DEFAULT_FILE, 3), arena=Arena(-2.0, 2.0, -1.0, 1.0))
NOW = 100.0
FREE = RobotView(
    1,
    pose=(0.0, 0.0, 0.0),
    measured=NOW - 0.01,
    received=NOW,
    same_since=NOW,
    judged=NOW,
    height=0.1,
    wanted=(0.1, 0.2),
    commanded=NOW - 0.1,
    driven_since=NOW - 5.0,
)
OTHERS = {2: (1.5, 0.5, 0.0), 3: (-1.5, 0.5, 0.0)}
PAUSED = {'pause': PauseReason(PauseCause.OPERATOR, 'paused')}
SILENT = {'pause': PauseReason(PauseCause.SILENT, 'no message')}
LATCHED = {'pause': PauseReason(PauseCause.LATCHED, 'robot 1: no command')}
RIVAL = {'trouble': StopReason(Cause.RIVAL, '/joy also commands it')}
DEAD = {'trouble': StopReason(Cause.GUARD_SILENT), 'charge': 4.0}
MOCAP_SILENT = {'measured': NOW - 0.51, 'received': NOW - 0.51}
RNG = np.random.default_rng(6)
MOVING, STOPS, PAUSES = BridgeState.MOVING, BridgeState.STOPPED, BridgeState.PAUSED


def decision(lab=LAB, pause=None, deviation='', others=OTHERS, height=0.1, **changes):
    robot = replace(FREE, **changes)
    robots = {
        number: RobotView(number, pose=pose, height=height) for number, pose in others.items()
    }
    deviations = {1: deviation} if deviation else {}
    fleet = FleetView(pause, {1: robot} | robots, {1: robot.wanted}, deviations)
    return decide(robot, fleet, lab, NOW)


def test_a_robot_stands_that_is_inside_an_obstacle():
    lab = replace(LAB, obstacles=Obstacles.of('disc 0 0.3 0.2; polygon 1 0 2 0 2 1'))

    result = decision(lab, pose=(0.0, 0.2, 0.0))

    assert (result.V, result.omega, result.why.cause.lasts) == (0.0, 0.0, True)
    assert result.text == 'inside an obstacle of the lab; carry it out'
    assert decision(lab).state is MOVING


def test_a_robot_that_nothing_speaks_against_gets_its_command():
    result = decision()

    assert (result.V, result.omega) == (0.1, 0.2)
    assert (result.state, result.text, result.why) == (MOVING, '', None)


@pytest.mark.parametrize(
    ('changes', 'state', 'text', 'cause'),
    [
        (PAUSED, PAUSES, 'paused', None),
        (PAUSED | {'pose': None}, PAUSES, 'paused; not seen yet', Cause.UNSEEN),
        (PAUSED | {'commanded': -math.inf}, PAUSES, 'paused; no com', Cause.NO_COMMAND),
        (SILENT, PAUSES, 'paused: no message', None),
        (
            LATCHED | {'wanted': (math.nan, 0.0)},
            PAUSES,
            'paused: robot 1: no c',
            Cause.NOT_A_NUMBER,
        ),
        ({'others': {2: None, 3: None}}, STOPS, 'robots 2-3 have not been', Cause.OTHERS_UNSEEN),
        (RIVAL, STOPS, '/joy also commands it', Cause.RIVAL),
        (DEAD, STOPS, 'its guard is silent; its battery was at 4 %', Cause.GUARD_SILENT),
        (RIVAL | {'deviation': 'drifts'}, STOPS, '/joy also', Cause.RIVAL),
        ({'pose': None}, STOPS, 'not seen yet', Cause.UNSEEN),
        ({'pose': None, 'pose_fault': 'tilted'}, STOPS, 'tilted', Cause.POSE_REJECTED),
        ({'pose_fault': 'tilted'}, STOPS, 'pose rejected: tilted', Cause.POSE_REJECTED),
        ({'judged': NOW - 0.51}, STOPS, 'mocap bridge is silent', Cause.POSE_REJECTED),
        ({'judged': -math.inf}, STOPS, 'mocap bridge is silent', Cause.POSE_REJECTED),
        ({'deviation': 'drifts'}, STOPS, 'pose rejected: drifts', Cause.DEVIATES),
        ({'same_since': NOW - 0.41}, STOPS, 'pose rejected: frozen', Cause.FROZEN),
        (MOCAP_SILENT, STOPS, 'no good pose for 0.5 s', Cause.POSE_OLD),
        ({'measured': NOW - 0.51}, STOPS, 'poses come 0.5 s late', Cause.POSE_LATE),
        ({'measured': -math.inf}, STOPS, 'late by their stamps', Cause.POSE_LATE),
        ({'measured': math.nan}, STOPS, 'no good pose', Cause.POSE_OLD),
        (
            {'commanded': NOW - 0.51},
            STOPS,
            'does a law publish /tb3_1/cmd_cart_vel?',
            Cause.NO_COMMAND,
        ),
        ({'commanded': math.nan}, STOPS, 'no command', Cause.NO_COMMAND),
        ({'wanted': (math.nan, 0.1)}, STOPS, 'not a number', Cause.NOT_A_NUMBER),
        ({'wanted': (0.1, math.inf)}, STOPS, 'not a number', Cause.NOT_A_NUMBER),
    ],
)
def test_whatever_is_missing_stops_a_robot(changes, state, text, cause):
    result = decision(**changes)

    assert (result.V, result.omega, result.state) == (0.0, 0.0, state)
    assert (result.why.cause if result.why else None) is cause
    assert text in result.text
    assert result.is_ready is (state is STOPS or changes == PAUSED)


def test_every_combination_of_what_is_missing_is_zero():
    bad = [
        PAUSED,
        {'others': {2: None}},
        RIVAL,
        {'same_since': NOW - 1.0},
        {'deviation': 'drifts'},
        {'pose_fault': 'jumped'},
        {'measured': NOW - 3.0},
        {'commanded': NOW - 3.0},
        {'wanted': (math.nan, 0.1)},
    ]
    for size in range(1, len(bad) + 1):
        for chosen in itertools.combinations(bad, size):
            changes = {key: value for part in chosen for key, value in part.items()}
            result = decision(**changes)
            assert (result.V, result.omega) == (0.0, 0.0), changes


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
    result = decision(pose=pose, wanted=(V, 0.0), others={})

    assert decision(pose=pose, wanted=(V, 1.0), others={}).omega == 1.0  # it may turn
    assert (V if goes else 0.0) == result.V
    assert result.state == (MOVING if goes else STOPS)
    assert ('outside' in result.text) == (pose[:2] != (2.0, 1.0))


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
        result = decision(pose=pose, wanted=(V, omega), others={})
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
        result = decision(pose=pose, wanted=(V, omega), others={2: other})
        let_through += result.V != 0.0
        distances = [
            math.dist(place, other[:2])
            for place in places_over_a_hold(pose, result.V, result.omega)
        ]
        assert np.diff(distances).min() >= -1e-12, (pose, other, V, omega)
    assert let_through > 500


def test_no_command_is_ever_beyond_the_limits():
    for V, omega in RNG.uniform(-1, 1, (2000, 2)) * (2.0, 20.0):
        result = decision(wanted=(V, omega))
        wheel = abs(result.V) + 0.5 * LAB.limits.wheel_separation * abs(result.omega)
        assert abs(result.V) <= LAB.limits.V_max + 1e-12
        assert abs(result.omega) <= LAB.limits.omega_max + 1e-12
        assert wheel <= LAB.limits.wheel_speed_max + 1e-12
        assert result.V * omega == pytest.approx(result.omega * V)


def test_too_near_says_to_whom_and_counts_the_edge_as_far_enough():
    near = decision(others={2: (0.3, 0.0, 0.0), 3: (0.0, 0.2, 0.0)})
    edge = decision(others={2: (LAB.min_separation, 0.0, 0.0)})

    assert near.state == STOPS
    assert 'closer than 0.35 m to robots 2-3; it may only move away' in near.text
    assert edge.state == MOVING
